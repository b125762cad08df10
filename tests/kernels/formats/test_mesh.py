"""Meshes in: PLY, OBJ and glTF, whole and damaged."""

from __future__ import annotations

import json
import random
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import trimesh
from tests.kernels.formats.test_fuzz import mutate

from woodcock.formats import mesh
from woodcock.formats.mesh import Mesh, MeshError, read_mesh

MUTATIONS = 1000
SECONDS = 2.0
TURN = np.array([[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 2, 7], [0, 0, 0, 1.0]])


def ball() -> trimesh.Trimesh:
    made = trimesh.creation.icosphere(subdivisions=0)
    assert len(made.vertex_normals) == 12
    return made


def scene() -> trimesh.Scene:
    made = trimesh.Scene()
    made.add_geometry(ball(), transform=TURN)
    made.add_geometry(trimesh.creation.box())
    return made


def files() -> dict[str, bytes]:
    parts = scene().export(file_type="gltf")
    return {
        "ball.ply": ball().export(file_type="ply", vertex_normal=True),
        "text.ply": ball().export(file_type="ply", encoding="ascii", vertex_normal=True),
        "ball.obj": ball().export(file_type="obj", include_normals=True).encode(),
        "scene.glb": scene().export(file_type="glb", include_normals=True),
        **parts,
    }


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, data in files().items():
        (tmp_path / name).write_bytes(data)
    return tmp_path


def triangles(found: Mesh) -> np.ndarray:
    """Sorted, so that the order in a file does not count."""
    corners = found.vertices[found.faces].reshape(-1, 9)
    return corners[np.lexsort(np.round(corners, 5).T)]


@pytest.mark.parametrize("name", ["ball.ply", "text.ply", "ball.obj"])
def test_a_mesh(folder: Path, name: str) -> None:
    found = read_mesh(folder / name)
    right = Mesh(ball().vertices, ball().faces)
    assert np.allclose(triangles(found), triangles(right), atol=1e-6)
    assert found.normals is not None
    assert np.allclose(found.normals, found.vertices, atol=1e-6)
    assert found.vertices.dtype == np.float64


@pytest.mark.parametrize("name", ["scene.glb", "model.gltf"])
def test_a_scene_is_placed_by_its_nodes(folder: Path, name: str) -> None:
    found = read_mesh(folder / name)
    box = trimesh.creation.box()
    moved = ball().vertices @ TURN[:3, :3].T + TURN[:3, 3]
    right = np.concatenate([moved[ball().faces].reshape(-1, 9), box.vertices[box.faces].reshape(-1, 9)])
    assert np.allclose(np.sort(triangles(found), axis=0), np.sort(right, axis=0), atol=1e-5)
    assert found.normals is not None
    far = found.vertices[:, 2] > 3
    away = (found.vertices[far] - TURN[:3, 3]) / (1, 1, 4)
    units = found.normals[far] / np.linalg.norm(found.normals[far], axis=1, keepdims=True)
    assert np.allclose(units, away / np.linalg.norm(away, axis=1, keepdims=True), atol=1e-5)


def test_a_mirrored_node_keeps_the_outside(tmp_path: Path) -> None:
    made = trimesh.Scene()
    made.add_geometry(ball(), transform=np.diag([-1.0, 1, 1, 1]))
    (tmp_path / "m.glb").write_bytes(made.export(file_type="glb"))
    corners = (found := read_mesh(tmp_path / "m.glb")).vertices[found.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((normal * corners.mean(axis=1)).sum(-1) > 0).all()


def test_polygons_become_fans(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 0.5 0\nf 1 2 3 4 5\n")
    found = read_mesh(tmp_path / "a.obj")
    corners = found.vertices[found.faces]
    assert np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2].sum() / 2 == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n", "negative indices"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", ""),
        ("v 0 0 0\nv 1 x 0\nv 0 1 0\nf 1 2 3\n", 'has a line that is no vertex or face: "v 1 x 0"'),
        ("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "no vertex or face"),
        ("v 0 0 0\nv 1 1e39 0\nv 0 1 0\nf 1 2 3\n", "not finite, or beyond 1e30"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "holds no triangle"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "no vertex or face"),
        ("solid\nfacet normal 0 0 1\n", "is no mesh that can be read; PLY, OBJ and glTF files can"),
        ("", "is no mesh that can be read"),
        ("ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n", "is cut short"),
        ("ply\nformat ascii 1.0\nelement vertex 1\n", "is cut short in its PLY header"),
    ],
)
def test_faults_are_named(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "fault"
    path.write_text(text)
    with pytest.raises(MeshError) as error:
        read_mesh(path)
    assert str(error.value).startswith(f"{path}: ")
    assert message in str(error.value)


def test_missing_files_are_named(tmp_path: Path) -> None:
    for path in (tmp_path / "none.ply", tmp_path):
        with pytest.raises(MeshError, match=str(path)):
            read_mesh(path)


def test_polygons_of_several_sizes_in_binary(tmp_path: Path) -> None:
    header = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\n"
    header += b"property float x\nproperty float y\nproperty float z\n"
    header += b"element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    vertices = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], "<f4").tobytes()
    faces = b"\3" + np.array([0, 1, 2], "<i4").tobytes() + b"\2" + np.array([0, 2, 3], "<i4").tobytes()
    (tmp_path / "mixed.ply").write_bytes(header + vertices + faces)
    with pytest.raises(MeshError, match="mixes polygons of several sizes"):
        read_mesh(tmp_path / "mixed.ply")


@pytest.mark.parametrize(
    "uri", ["../secret.bin", "/etc/hostname", "sub/../../secret.bin", "%2e%2e/secret.bin", "link.bin"]
)
def test_buffers_lie_in_the_folder(folder: Path, uri: str) -> None:
    inside = folder / "inside"
    inside.mkdir()
    (folder / "secret.bin").write_bytes((folder / "gltf_buffer_0.bin").read_bytes())
    (inside / "link.bin").symlink_to(folder / "secret.bin")
    tree = json.loads((folder / "model.gltf").read_bytes())
    tree["buffers"][0]["uri"] = uri
    (inside / "model.gltf").write_text(json.dumps(tree))
    with pytest.raises(MeshError, match="names a buffer outside its folder"):
        read_mesh(inside / "model.gltf")


def test_buffers_are_never_fetched(folder: Path) -> None:
    tree = json.loads((folder / "model.gltf").read_bytes())
    for uri in ("http://example.org/a.bin", "file:///etc/hostname"):
        tree["buffers"][0]["uri"] = uri
        (folder / "model.gltf").write_text(json.dumps(tree))
        with pytest.raises(MeshError, match="names a buffer"):
            read_mesh(folder / "model.gltf")


def survive(data: bytes, path: Path) -> bool:
    path.write_bytes(data)
    start = time.perf_counter()
    fault = None
    try:
        found = read_mesh(path)
    except MeshError as error:
        fault = str(error)
    assert time.perf_counter() - start < SECONDS
    if fault is not None:
        assert fault.startswith(f"{path}: ")
        assert "\n" not in fault
        return False
    assert np.isfinite(found.vertices).all()
    assert 0 <= found.faces.min() <= found.faces.max() < len(found.vertices)
    assert found.normals is None or found.normals.shape == found.vertices.shape
    return True


@pytest.mark.parametrize("name", ["ball.ply", "text.ply", "ball.obj", "scene.glb", "model.gltf"])
def test_mutated_files(folder: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the bytes are, the answer is a mesh or one MeshError, soon, and in bounded memory."""
    monkeypatch.setattr(mesh, "MAX_FACES", 1 << 16)
    original = (folder / name).read_bytes()
    rng = random.Random(2013)
    assert survive(original, folder / "original")
    tracemalloc.start()
    readable = sum(survive(mutate(original, rng), folder / "mutant") for _ in range(MUTATIONS))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1 << 24
    assert 0 < readable < MUTATIONS
