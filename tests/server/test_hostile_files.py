"""Files made to harm: each is taken or refused in a sentence, soon, and nothing else is read, run or kept."""

from __future__ import annotations

import io
import json
import pickle
import re
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.kernels.formats.conftest import NanoVdbGrid, VdbGrid, encode_file, encode_nanovdb, string

from . import hostile
from .files import CUBE, npy, npz

READABLE = ("volume", "mesh", "picture")
PASSWORDS = "/etc/passwd"
LEAF = (np.ones((512, 1)), np.ones(512, bool))


def archive(*members: tuple[str, bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as written:
        for name, data in members:
            written.writestr(name, data)
    return stream.getvalue()


def array(shape: str, values: bytes = b"", descr: str = "'<f4'") -> bytes:
    """A .npy file by what its header says."""
    text = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}}}".encode()
    return b"\x93NUMPY\2\0" + struct.pack("<I", len(text)) + text + values


def announced(data: bytes, size: int) -> bytes:
    """A zip file of one member, whose directory says that it unpacks to so many bytes."""
    entry = data.index(b"PK\1\2")
    return data[: entry + 24] + struct.pack("<I", size) + data[entry + 28 :]


def overlapping(count: int) -> bytes:
    """A zip file whose many members are all the same bytes."""
    one = archive(("0.npy", npy(np.zeros((64, 64, 64)))))
    entry = one.index(b"PK\1\2")
    name = entry + 46
    entries = b"".join(one[entry:name] + b"%c.npy" % n for n in range(48, 48 + count))
    return one[:entry] + entries + struct.pack("<4s4H2IH", b"PK\5\6", 0, 0, count, count, len(entries), entry, 0)


def nrrd(sizes: str = "2 2 2", more: str = "", encoding: str = "raw", values: bytes = bytes(32)) -> bytes:
    dimension = len(sizes.split())
    fields = f"type: float\ndimension: {dimension}\nsizes: {sizes}\nencoding: {encoding}\nendian: little\n{more}"
    return hostile.nrrd(fields, values)


def ply(elements: str, values: bytes = b"") -> bytes:
    return f"ply\nformat binary_little_endian 1.0\n{elements}\nend_header\n".encode() + values


def gltf(**replaced: Any) -> bytes:
    """One triangle, with keys of the whole replaced."""
    corners = np.eye(3, dtype="<f4").tobytes()
    tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 36, "uri": "0"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    } | replaced
    if tree["buffers"][0]["uri"] == "0":
        hostile.embedded(tree, {"0": corners})
    return json.dumps(tree).encode()


def exr(*window: int) -> bytes:
    """The corners of its pixels replaced."""
    data = hostile.valid()["exr"]
    at = data.index(b"dataWindow\0box2i\0") + 21
    return data[:at] + struct.pack("<4i", *window) + data[at + 16 :]


def gzip_bomb() -> bytes:
    """A NIfTI header that announces 8 GiB, packed."""
    header = bytearray(hostile.valid()["nifti"][:352])
    struct.pack_into("<8h", header, 40, 3, 2048, 1024, 1024, 1, 1, 1, 1)
    packer = zlib.compressobj(9, wbits=31)
    return packer.compress(bytes(header) + bytes(1 << 20)) + packer.flush()


class Writes:
    """Writes a file, if it is ever unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return Path.write_text, (self.path, "executed")


def pickles(marker: Path) -> dict[str, bytes]:
    """By format; each would write the marker."""
    held = np.empty((1, 1, 1), object)
    held[0, 0, 0] = Writes(marker)
    single, several = io.BytesIO(), io.BytesIO()
    np.save(single, held, allow_pickle=True)
    np.savez(several, density=held, allow_pickle=True)
    return {"npy": single.getvalue(), "npz": several.getvalue(), "pickle": pickle.dumps(Writes(marker))}


# What is refused, and how


def refused() -> dict[str, tuple[bytes, str]]:
    """Files, and what is said of them."""
    far = dict.fromkeys([(0, 0, 0), (1 << 20, 1 << 20, 1 << 20)], LEAF)
    zipped = encode_nanovdb(NanoVdbGrid("float", {(0, 0, 0): LEAF}), codec=1)
    vdb = encode_file(VdbGrid({(0, 0, 0): LEAF}))
    name = vdb.index(string("density"))
    xyz = "property float x\nproperty float y\nproperty float z"
    faces = "property list uchar int vertex_indices"
    deep = b'{"nodes":' + b"[" * 200_000 + b"]" * 200_000 + b"}"
    nodes = [{"mesh": 0} for _ in range(10)]
    return {
        # Declared, and not there
        "npz of 2^36 voxels": (archive(("a.npy", array("(4096, 4096, 4096)"))), "more than the 8589934592"),
        "npz of a vast directory": (
            announced(archive(("a.npy", array("(1, 1, 1)"))), 1 << 30),
            "where 10012 are due",
        ),
        "npz of vast vectors": (archive(("a.npy", array("(2048, 2048, 2047, 3)"))), "this machine's memory|not those"),
        "npy of 2^36 voxels": (array("(4096, 4096, 4096)"), "more than the 8589934592"),
        "npy of 2^30 voxels": (array("(1024, 1024, 1024)"), "announces 4294967296 bytes of values, 0 follow"),
        "nrrd of 10^18 voxels": (nrrd("1000000 1000000 1000000"), "more than the 8589934592"),
        "nrrd bzip2 of 2^36": (nrrd("4096 4096 4096", encoding="bzip2"), "more than the 8589934592"),
        "nrrd gzip of 8 GiB": (nrrd("2048 1024 1024", encoding="gzip"), "33 packed bytes cannot hold 8589934592"),
        "nifti gzip of 8 GiB": (gzip_bomb(), r"\d+ packed bytes cannot hold 8589934944"),
        "vol of 2^93": (
            struct.pack("<3sB5i6f", b"VOL", 3, 1, *[(1 << 31) - 1] * 3, 1, *[0.0] * 6),
            "more than the 8589",
        ),
        "vdb of 2^60": (encode_file(VdbGrid(far)), "no grid of 8589934592 voxels or fewer; the first spans 1048584 ×"),
        "vdb of 2^32 grids": (vdb[: name - 4] + b"\xff" * 4 + vdb[name:], "has 4294967295 grids, more than the 10000"),
        "vdb of a long name": (vdb[:name] + b"\xff" * 4 + vdb[name + 4 :], "4294967295 bytes are due"),
        "nanovdb of 1 TiB": (zipped[:16] + struct.pack("<Q", 1 << 40) + zipped[24:], "cannot hold 1099511627776"),
        "ply of 10^18": (ply(f"element vertex {10**18 - 1}\n{xyz}"), "its header announces more than follows"),
        "ply of 10^19": (ply(f"element vertex {10**19}\n{xyz}"), "an element in its PLY header that is none"),
        "ply in Python's digits": (
            ply(f"element vertex 1_000_000\n{xyz}"),
            "an element in its PLY header that is none",
        ),
        "ply of a long list": (
            ply(
                f"element vertex 3\n{xyz}\nelement face 1\nproperty list int int vertex_indices",
                bytes(36) + b"\xff\xff\xff\x7f",
            ),
            "is no PLY file",
        ),
        "ply too large": (
            ply(f"element face {(1 << 24) + 1}\n{faces}", bytes(17 << 20)),
            "16777217 triangles; 16777216 are",
        ),
        "exr of 2^62 pixels": (exr(0, 0, (1 << 31) - 1, (1 << 31) - 1), "cannot be read"),
        "exr of 2^64 pixels": (exr(-(1 << 31), -(1 << 31), (1 << 31) - 1, (1 << 31) - 1), "cannot be read"),
        "exr of 2^30 pixels": (
            exr(0, 0, (1 << 15) - 1, (1 << 15) - 1),
            "its header is damaged, or announces more than the file can hold",
        ),
        "exr turned inside out": (exr(5, 5, 2, 2), "cannot be read"),
        "hdr of 2^62 pixels": (b"#?RADIANCE\n\n-Y 2147483647 +X 2147483647\n", "cannot be read"),
        "hdr of -5 pixels": (b"#?RADIANCE\n\n-Y -5 +X 5\n", "cannot be read"),
        "gltf of 2^31 corners": (
            gltf(accessors=[{"bufferView": 0, "componentType": 5126, "count": 1 << 31, "type": "VEC3"}]),
            "more than 2147483648 bytes together",
        ),
        "gltf of -3 corners": (
            gltf(accessors=[{"bufferView": 0, "componentType": 5126, "count": -3, "type": "VEC3"}]),
            "has a damaged accessor",
        ),
        "gltf of a stride of 0": (
            gltf(bufferViews=[{"buffer": 0, "byteLength": 36, "byteStride": 0}]),
            "is no glTF file",
        ),
        # There, and more than what was declared, or over and over
        "npz that unpacks to more": (
            archive(("a.npy", array("(2, 2, 2)", bytes(1 << 24)))),
            "are not those of an array",
        ),
        "npz in npz": (archive(("a.npz", archive(("a.npy", npy(np.ones((1, 1, 1))))))), "holds no array"),
        "npz as npy": (archive(("a.npy", archive(("a.npy", npy(np.ones((1, 1, 1))))))), "is no .npy array"),
        "gltf of one triangle 10^7 times": (
            gltf(meshes=[{"primitives": [{"attributes": {"POSITION": 0}}] * 20_000}], nodes=nodes * 100),
            "holds 20000000 triangles; 16777216 are the most",
        ),
        "gltf of one view 10^8 times": (
            gltf(bufferViews=[{"buffer": 0, "byteLength": 1 << 20}] * 3000),
            "more than 2147483648 bytes together",
        ),
        "gltf in a circle": (
            gltf(nodes=[{"children": [1]}, {"children": [0, 1]}]),
            "a node that is the child of several",
        ),
        # Long, deep or slow to understand
        "npy of a million dimensions": (
            array("(" + "1," * 1_000_000 + ")"),
            "header of 2000053 bytes, more than 10000",
        ),
        "npy of 3000 dimensions": (array("(" + "1," * 3000 + ")"), "must be indexed"),
        "npy of a deep header": (array("(" * 9000), "has a damaged .npy header"),
        "npy of negative size": (array("(-1, 2, 2)", bytes(64)), "has a damaged shape"),
        "npy of records": (array("(1, 1, 1)", bytes(64), "[('a', '<f4', (1000000000,))]"), "not records"),
        "npy of a long header": (b"\x93NUMPY\2\0\xff\xff\xff\xff" + bytes(9), "is cut short in its .npy header"),
        "nrrd of a long header": (b"NRRD0004\n" + b"a: b\n" * (1 << 20), "no empty line within 1048576 bytes"),
        "nrrd of a million axes": (nrrd("1 " * 100_000), "has no sizes that can be read"),
        "ply of a long header": (
            ply("element vertex 1\n" + "property float x\n" * 50_000, bytes(4)),
            "is no PLY file",
        ),
        "obj of a long number": (b"v 0 0 0\nv " + b"1" * 100_000 + b"x 0 0\n", "has a line that is no vertex"),
        "gltf that is deep": (deep, "is no glTF file that can be read"),
        "gltf in another encoding": (gltf().decode().encode("utf-16-le"), "is no glTF file that can be read"),
        # Numbers that are none
        "obj of nan": (CUBE.replace(b"v -1 -1 -1", b"v nan -1 -1"), "has a line that is no vertex"),
        "ply of nan": (
            ply(
                f"element vertex 3\n{xyz}\nelement face 1\n{faces}",
                np.full(9, np.nan, "<f4").tobytes() + b"\3" + bytes(12),
            ),
            "has vertices that are not finite",
        ),
        # Of elsewhere
        "nrrd of another file": (nrrd(more=f"data file: {PASSWORDS}"), "it must be one file of the same folder"),
        "nrrd of the folder above": (nrrd(more="data file: ../secret"), "it must be one file of the same folder"),
        "nrrd of a list of files": (nrrd(more="data file: LIST\nsecret"), "which cannot be read"),
        "gltf of another file": (gltf(buffers=[{"byteLength": 36, "uri": PASSWORDS}]), "a buffer outside its folder"),
        "gltf of the folder above": (gltf(buffers=[{"byteLength": 36, "uri": "..%2fsecret"}]), "outside its folder"),
        "gltf of a URL": (gltf(buffers=[{"byteLength": 36, "uri": f"file://{PASSWORDS}"}]), "outside its folder"),
    }


def test_what_was_made_to_harm_is_refused_in_a_sentence(tmp_path: Path) -> None:
    marker, files = tmp_path / "marker", refused()
    for kind, data in pickles(marker).items():
        files[f"pickle in {kind}"] = data, "is no file that can be read" if kind == "pickle" else "not .*O"
    (tmp_path / "in").mkdir()
    (tmp_path / "secret").write_bytes(bytes(64))
    said = hostile.outcomes(tmp_path / "in", {name: data for name, (data, _) in files.items()})
    assert {name: said[name] for name, (_, right) in files.items() if not re.search(right, said[name])} == {}
    assert not marker.exists()
    pickle.loads(pickles(marker)["pickle"])
    assert marker.exists(), "it would have been written"


def test_odd_names_and_numbers_are_data(tmp_path: Path) -> None:
    """What looks dangerous and is not: names in a file are no paths, and values are looked at when they are used."""
    ones = np.ones((2, 2, 2), "f4")
    files = {
        "npz of a path": npz(**{"../../../tmp/x": ones, PASSWORDS: ones}),
        "npz of one member 10 times": overlapping(10),
        "npy of nan": npy(np.full((2, 2, 2), np.nan)),
        "vol of nan": struct.pack("<3sB5i6f", b"VOL", 3, 1, 1, 1, 1, 1, *[float("nan")] * 6) + bytes(4),
        "obj of materials": f"mtllib {PASSWORDS}\nusemtl a\n".encode() + CUBE,
        "gltf of images": gltf(images=[{"uri": PASSWORDS}], textures=[{"source": 0}], materials=[{}]),
        "ply of a texture": ply(
            f"comment TextureFile {PASSWORDS}\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 1\nproperty list uchar int vertex_indices",
            np.eye(3, dtype="<f4").tobytes() + b"\3" + np.arange(3, dtype="<i4").tobytes(),
        ),
    }
    said = hostile.outcomes(tmp_path, files)
    assert said == {name: "volume" if name.split()[0] in ("npz", "npy", "vol") else "mesh" for name in files}


# Damage


def test_damaged_files_are_taken_or_refused_in_a_sentence(tmp_path: Path) -> None:
    files = dict(hostile.valid())
    for name, data in hostile.valid().items():
        for seed, mutant in enumerate(hostile.mutants(data, 10, seed=1965)):
            files[f"{name}, mutant {seed}"] = mutant
        for eighth in range(8):
            files[f"{name}, {eighth} eighths"] = data[: eighth * len(data) // 8]
    _make_sense(hostile.outcomes(tmp_path, files))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_many_damaged_files_are_taken_or_refused_in_a_sentence(tmp_path: Path, seed: int) -> None:
    for name, data in {**hostile.valid(), **hostile.pictures()}.items():
        folder = tmp_path / name
        folder.mkdir()
        files = {f"{name}, mutant {n}": mutant for n, mutant in enumerate(hostile.mutants(data, 300, seed))}
        _make_sense(hostile.outcomes(folder, {name: data, **files}))


def _make_sense(said: dict[str, str]) -> None:
    assert {
        name: outcome for name, outcome in said.items() if outcome.startswith("failed") or outcome == "memory"
    } == {}
    whole = {name: outcome for name, outcome in said.items() if "," not in name}
    assert {name: outcome for name, outcome in whole.items() if outcome not in READABLE} == {}
