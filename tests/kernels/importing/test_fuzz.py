"""Damaged scenes: each becomes a scene that loads or one SourceError, and never anything else."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from tests.kernels.importing.scenes import mitsuba, pbrt

from woodcock.importing import Report, SourceError, convert
from woodcock.scene import load

MITSUBA = mitsuba(
    """<default name="g" value="0.5"/> <alias id="fog" as="haze"/>
<medium type="homogeneous" id="fog"> <rgb name="sigma_t" value="1, 2, 3"/> <float name="scale" value="2"/>
  <phase type="blendphase"> <float name="weight" value="0.25"/>
    <phase type="hg"> <float name="g" value="$g"/> </phase> <phase type="rayleigh"/> </phase> </medium>
<medium type="heterogeneous" id="cloud"> <volume type="gridvolume" name="sigma_t">
  <string name="filename" value="a.vol"/> <transform name="to_world"> <scale value="2"/> </transform> </volume>
</medium>
<bsdf type="roughdielectric" id="glass"> <string name="int_ior" value="water"/> <float name="alpha" value=".2"/> </bsdf>
<shape type="cube"> <ref id="glass"/> <ref name="interior" id="haze"/> <transform name="to_world">
  <rotate x="1" angle="20"/> <matrix value="1 0 0 0 1 0 0 0 1"/> </transform> </shape>
<shape type="sphere"> <bsdf type="null"/> <ref name="interior" id="cloud"/> <float name="radius" value="2"/> </shape>
<shape type="disk"> <emitter type="area"> <spectrum name="radiance" value="400:1, 700:2"/> </emitter> </shape>
<emitter type="spot"> <transform name="to_world"> <lookat origin="0 3 0" target="0 0 0" up="0 0 1"/> </transform>
</emitter>
<emitter type="directional"> <vector name="direction" x="0" y="-1" z="0"/> </emitter>""",
    """<sensor type="thinlens"> <float name="fov" value="40"/> <string name="fov_axis" value="smaller"/>
<float name="aperture_radius" value="0.1"/> <float name="focus_distance" value="3"/>
<film type="hdrfilm"> <integer name="width" value="20"/> <rfilter type="box"/> </film>
<sampler type="independent"> <integer name="sample_count" value="8"/> </sampler> </sensor>""",
)
PBRT = pbrt(
    """MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [ 1 2 3 ] "float g" 0.5 "blackbody Le" 3000
MakeNamedMedium "smoke" "string type" "uniformgrid" "float density" [ 0 1 2 3 ] "integer nx" 2 "integer ny" 2
  "float temperature" [ 300 400 500 600 ] "point3 p0" [ -1 -1 -1 ]
MakeNamedMedium "dust" "string type" "rgbgrid" "rgb sigma_a" [ 1 2 3 ] "rgb Le" [ 1 1 1 ]
AttributeBegin Translate 1 0 0 Material "interface" MediumInterface "fog" "" Shape "sphere" "float radius" 2
MediumInterface "smoke" "" Shape "sphere" MediumInterface "dust" "fog" Shape "sphere" AttributeEnd
Texture "t" "spectrum" "constant" "rgb value" [ 1 0 0 ] Material "diffuse" "texture reflectance" "t"
ObjectBegin "o" Shape "trianglemesh" "point3 P" [ 0 0 0 1 0 0 0 1 0 ] "integer indices" [ 0 1 2 ] ObjectEnd
Rotate 90 0 1 0 ObjectInstance "o" CoordinateSystem "here" CoordSysTransform "here"
Material "dielectric" "spectrum eta" [ 300 1.3 800 1.3 ] "float roughness" 0.1 Shape "disk" "float radius" 3
AreaLightSource "diffuse" "rgb L" [ 1 2 3 ] ReverseOrientation
Shape "bilinearmesh" "point3 P" [ -1 -1 0 1 -1 0 -1 1 0 1 1 0 ]
LightSource "spot" "point3 from" [ 0 3 0 ] "float power" 5 LightSource "infinite" "rgb L" [ 1 1 1 ]""",
    """Film "rgb" "integer xresolution" 20 "integer yresolution" 10 Sampler "halton" "integer pixelsamples" 4
Scale -1 1 1 LookAt 0 0 -5 0 0 0 0 1 0 Camera "perspective" "float fov" 30 "float lensradius" 0.1""",
)
SPICES = [
    *(
        "",
        "0",
        "-1",
        "1e300",
        "-1e-300",
        "nan",
        "inf",
        "1e999",
        "0.5",
        "99999999999999999999",
        "x",
        "\N{SNOWMAN}",
        "$a",
    ),
    *('"', "<", ">", "/", "[", "]", "#", "&lt;", "&a;", "..", "a.vol", "true", "\0", "-0", "1 2", "#ff0000", "400:1"),
]
VALUES = re.compile(r"(?<=\")[^\"<>]+(?=\")|(?<= )[\d.-]+(?= )")
PARTS = re.compile(r"\s+|[^\s\"<>=/]+|.", re.DOTALL)


def mutated(text: str, random_: random.Random) -> str:
    """Values in quotes or brackets changed for others; or a few words dropped, doubled, moved or changed."""
    if random_.random() < 0.6:
        places = list(VALUES.finditer(text))
        place = random_.choice(places)
        alike = [other[0] for other in places if other[0][-1].isdigit() == place[0][-1].isdigit()]
        value = random_.choice([random_.choice(SPICES), random_.choice(alike)])
        return text[: place.start()] + value + text[place.end() :]
    words = PARTS.findall(text)
    for _ in range(random_.randint(1, 4)):
        at = random_.randrange(len(words))
        match random_.randrange(6):
            case 0:
                del words[at : at + random_.randint(1, 4)]
            case 1:
                words[at:at] = words[at : at + random_.randint(1, 8)]
            case 2:
                words[at] = random_.choice(SPICES)
            case 3:
                words[at] = random_.choice(words)
            case 4:
                del words[at + random_.randint(0, 400) :]
            case _:
                other = random_.randrange(len(words))
                words[at], words[other] = words[other], words[at]
        words = words or ["x"]
    return "".join(words)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("name", "text"), [("scene.xml", MITSUBA), ("scene.pbrt", PBRT)], ids=["mitsuba", "pbrt"])
def test_damaged_scenes(tmp_path: Path, name: str, text: str, seed: int) -> None:
    source, target = tmp_path / name, tmp_path / "out.json"
    source.write_text(text)
    convert(source, target, Report())
    random_ = random.Random(seed)
    read = 0
    for _ in range(30):
        damaged = mutated(text, random_)
        source.write_text(damaged)
        target.unlink(missing_ok=True)
        try:
            convert(source, target, Report())
        except SourceError:
            assert not target.exists()
        else:
            load(target)
            read += 1
    assert 1 < read < 29


@pytest.mark.parametrize(
    "start", [b"", b"<", b"<scene", b"WorldBegin ", b"\xef\xbb\xbf<scene/>", b'<?xml encoding="x"?>']
)
def test_bytes_that_are_no_text(tmp_path: Path, start: bytes) -> None:
    random_ = random.Random(len(start))
    for _ in range(30):
        (tmp_path / "scene").write_bytes(start + random_.randbytes(random_.randint(0, 200)))
        with pytest.raises(SourceError):
            convert(tmp_path / "scene", tmp_path / "out.json", Report())


def test_includes_cannot_multiply_without_bounds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("woodcock.importing.pbrt.state.MAX_BYTES", 1 << 16)
    monkeypatch.setattr("woodcock.importing.mitsuba.xml.MAX_NODES", 1 << 10)
    for number in range(12):
        (tmp_path / f"{number}.pbrt").write_text(f'Include "{number + 1}.pbrt"\n' * 3)
        include = f'<include filename="{number + 1}.xml"/>'
        (tmp_path / f"{number}.xml").write_text(f"<scene>{include * 3}</scene>")
    (tmp_path / "12.pbrt").write_text("Identity\n")
    (tmp_path / "12.xml").write_text("<scene><shape/></scene>")
    for suffix, message in (("pbrt", "the scene is larger than"), ("xml", "the scene has more than")):
        with pytest.raises(SourceError, match=message):
            convert(tmp_path / f"0.{suffix}", tmp_path / "out.json", Report())
