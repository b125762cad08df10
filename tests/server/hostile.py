"""Small files of every format that is taken, what damage makes of them, and what the service would say of those."""

from __future__ import annotations

import base64
import bz2
import gzip
import json
import os
import random
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import nibabel
import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
from tests.kernels.formats.conftest import NanoVdbGrid, VdbGrid, encode_file, encode_nanovdb, string
from tests.kernels.formats.test_fuzz import mutate
from tests.kernels.formats.test_mesh import files as meshes

from woodcock_server.volumes.parser import ONE_THREAD

from .files import CUBE, fire, npy

VALUES = np.linspace(0, 1, 60, dtype="<f4").reshape(3, 4, 5)
COMPRESSIONS = ("none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab")


def nrrd(fields: str, values: bytes) -> bytes:
    return f"NRRD0004\n{fields}\n\n".encode() + values


def picture(suffix: str, tile: int = 0, compression: str = "zip", base: str = "half") -> bytes:
    # Of few values: what cannot be packed would be stored as it is.
    y, x, channel = np.indices((16, 32, 3))
    pixels = np.ascontiguousarray((y // 4 + x // 4 * channel) / 8, np.float32)
    spec = oiio.ImageSpec(32, 16, 3, base)
    spec.attribute("compression", compression)
    spec.tile_width = spec.tile_height = tile
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"picture.{suffix}"
        image = oiio.ImageOutput.create(str(path))
        assert image.open(str(path), spec)
        assert image.write_image(pixels)
        image.close()
        return path.read_bytes()


@cache
def valid() -> dict[str, bytes]:
    """By format."""
    drawn = np.random.default_rng(1)
    leaves: dict[Any, Any] = {at: (drawn.random((512, 1)), drawn.random(512) < 0.5) for at in [(0, 0, 0), (8, 8, -8)]}
    tiles: dict[Any, Any] = {((16, 0, 0), 4): (0.5, True)}
    raw, sizes = VALUES.tobytes(), "type: float\ndimension: 3\nsizes: 5 4 3\nendian: little\n"
    nifti = nibabel.Nifti1Image(VALUES.T, np.eye(4)).to_bytes()
    parts = meshes()
    return {
        "vdb": encode_file(VdbGrid(leaves, tiles), VdbGrid(leaves, name="heat", half=True, flags=3)),
        "nanovdb": encode_nanovdb(NanoVdbGrid("float", leaves, tiles), codec=2),
        "nanovdb zip": encode_nanovdb(NanoVdbGrid("fpN", leaves), NanoVdbGrid("half", leaves), codec=1),
        "nanovdb bare": NanoVdbGrid("fp8", leaves).encode(),
        "npy": npy(VALUES),
        "npz": fire(),
        "vol": struct.pack("<3sB5i6f", b"VOL", 3, 1, 5, 4, 3, 1, 0, 0, 0, 1, 1, 1) + raw,
        "nrrd": nrrd(f"{sizes}encoding: raw", raw),
        "nrrd gzip": nrrd(f"{sizes}encoding: gzip", gzip.compress(raw, mtime=0)),
        "nrrd bzip2": nrrd(f"{sizes}encoding: bzip2", bz2.compress(raw)),
        "nifti": nifti,
        "nifti gzip": gzip.compress(nifti, mtime=0),
        "ply": parts["ball.ply"],
        "ply text": parts["text.ply"],
        "obj": CUBE,
        "glb": parts["scene.glb"],
        "gltf": json.dumps(embedded(json.loads(parts["model.gltf"]), parts)).encode(),
        "exr": picture("exr"),
        "hdr": picture("hdr", base="float"),
    }


def embedded(tree: dict[str, Any], parts: dict[str, bytes]) -> dict[str, Any]:
    """A glTF file whose buffers are inside."""
    for buffer in tree["buffers"]:
        buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(parts[buffer["uri"]]).decode()
    return tree


def instances(count: int) -> bytes:
    """An OpenVDB file of one grid and so many others that use its tree."""
    leaf = np.ones((512, 1)), np.ones(512, bool)
    data = encode_file(VdbGrid({(8 * n, 0, 0): leaf for n in range(8)}))
    at = data.index(string("density"))
    data = data[: at - 4] + struct.pack("<I", count + 1) + data[at:]
    head = struct.pack("<2I", 0, 0) + string("UniformScaleMap") + np.ones(15).tobytes()
    for n in range(count):
        data += string(f"i{n}") + string("Tree_float_5_4_3") + string("density")
        start = len(data) + 24
        data += struct.pack("<3q", start, start, start + len(head)) + head
    return data


def pictures() -> dict[str, bytes]:
    """Of every compression of OpenEXR."""
    flat = {f"exr {name}": picture("exr", 0, name) for name in COMPRESSIONS}
    return flat | {f"exr {name} tiled": picture("exr", 16, name, "float") for name in COMPRESSIONS}


def mutants(original: bytes, count: int, seed: int) -> Iterator[bytes]:
    rng = random.Random(seed)
    for _ in range(count):
        yield mutate(original, rng)


def outcomes(folder: Path, files: dict[str, bytes]) -> dict[str, str]:
    """What a child process says of each file (`hostile_reader.py`); all in one, for it takes a second to begin."""
    names = {f"{place:06}": name for place, name in enumerate(files)}
    for written, name in names.items():
        (folder / written).write_bytes(files[name])
    done = subprocess.run(
        [sys.executable, "-m", "tests.server.hostile_reader", str(folder)],
        capture_output=True,
        text=True,
        timeout=250,
        check=False,
        env={**os.environ, **ONE_THREAD},
    )
    said = {names[written]: outcome for written, outcome in map(json.loads, done.stdout.splitlines())}
    assert len(said) == len(files), f"{list(files)[len(said)]} ended the process: {done.returncode} {done.stderr}"
    return said
