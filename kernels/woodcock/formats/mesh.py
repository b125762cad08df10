"""Meshes in: PLY, OBJ and glTF (also binary), chosen by what the file begins with, read by trimesh.

What trimesh would take silently for something else is refused before or after: indices that count back in OBJ, polygons
of several sizes in binary PLY, sparse or compressed accessors in glTF. No size that a file states is believed before it
is checked against the bytes that are there; a glTF file's buffers lie in its folder or below.
"""

from __future__ import annotations

import io
import json
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import numpy.typing as npt

from woodcock.formats.grid import Data, VolumeError, opened, quoted

#: Most triangles and vertices of a mesh, and bytes of its file.
MAX_FACES = 1 << 24
MAX_VERTICES = 3 * MAX_FACES
MAX_BYTES = 1 << 31

Array = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_NUMBER = rb"[ \t]+[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
# Lines of an OBJ file that begin like a vertex or a face and are none
_BAD_LINE = re.compile(
    rb"^(?:vn?(?=[ \t])(?!(?:" + _NUMBER + rb"){3,8}[ \t]*$)|f(?=[ \t])(?!(?:[ \t]+\d+(?:/\d*){0,2}){3,}[ \t]*$))",
    re.MULTILINE,
)


class MeshError(VolumeError):
    """A file that cannot be read as a mesh, or a mesh that cannot be what it is used for; the text names the file."""


@dataclass(frozen=True)
class Mesh:
    """vertices: (n, 3) finite; faces: (m, 3) indices of vertices, counter-clockwise seen from outside; normals: of
    vertices, (n, 3), of any length, zero where there is none."""

    vertices: Array
    faces: Integers
    normals: Array | None = None


def recognises(path: Path) -> bool:
    """Is the file a mesh by what it begins with? Raises OSError."""
    return _format(opened(path).data) is not None


def read_mesh(path: Path) -> Mesh:
    """The triangles of a file, all its objects in one. Raises MeshError, whose text starts with the path."""
    try:
        return _read(path)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None
    except OSError as error:
        raise MeshError(f"{path}: {error.strerror}") from None
    except MemoryError as error:
        raise MeshError(f"{path}: needs more memory than there is") from error


def _read(path: Path) -> Mesh:
    if "\0" in str(path):
        raise MeshError("is no name of a file")
    if path.exists() and not path.is_file():
        raise MeshError("is not a file")
    data = _bytes(path)
    match _format(data):
        case "PLY":
            return _checked(_understood("PLY", _ply, data))
        case "glTF":
            return _checked(_understood("glTF", _gltf, data, path.parent))
        case "OBJ":
            return _checked(_understood("OBJ", _obj, data))
    raise MeshError("is no mesh that can be read; PLY, OBJ and glTF files can")


def _format(data: Data) -> str | None:
    if data[:4] in (b"ply\n", b"ply\r"):
        return "PLY"
    if data[:4] == b"glTF" or re.match(rb"\s*\{", data):
        return "glTF"
    # No binary file of any size is searched to its end.
    if data.find(b"\0") < 0 and re.search(rb"^v[ \t]", data, re.MULTILINE):
        return "OBJ"
    return None


def _bytes(path: Path) -> bytes:
    if path.stat().st_size > MAX_BYTES:
        raise MeshError(f"is larger than {MAX_BYTES} bytes")
    return path.read_bytes()


def _understood(name: str, read: Callable[..., Mesh], *arguments: Any) -> Mesh:
    """What a reader makes of a file. A damaged file may raise anything in it."""
    try:
        return read(*arguments)
    except (VolumeError, OSError, MemoryError):
        raise
    except Exception as error:
        raise MeshError(f"is no {name} file that can be read: {quoted(str(error) or type(error).__name__)}") from None


def _checked(mesh: Mesh) -> Mesh:
    """The mesh, with everything that must hold of one."""
    if not len(mesh.faces):
        raise MeshError("holds no triangle")
    _check_counts(len(mesh.faces), len(mesh.vertices))
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise MeshError(f"has a face that names a vertex it lacks; it has {len(mesh.vertices)}")
    if not np.isfinite(mesh.vertices).all() or np.abs(mesh.vertices).max() > 1e30:
        raise MeshError("has vertices that are not finite, or beyond 1e30")
    if mesh.normals is not None and not np.isfinite(mesh.normals).all():
        raise MeshError("has normals that are not finite")
    return mesh


def _check_counts(faces: int, vertices: int) -> None:
    """Refuses a mesh that is too large, by what its file announces."""
    if faces > MAX_FACES:
        raise MeshError(f"holds {faces} triangles; {MAX_FACES} are the most")
    if vertices > MAX_VERTICES:
        raise MeshError(f"holds {vertices} vertices; {MAX_VERTICES} are the most")


def _mesh(parts: Mapping[str, Any]) -> Mesh:
    """A mesh of what trimesh's readers return for an object."""
    if parts.get("faces") is None or parts.get("vertices") is None:
        raise MeshError("holds no triangle")
    vertices = np.array(parts["vertices"], np.float64)
    faces = np.asarray(parts["faces"])
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.dtype.kind not in "iu":
        raise MeshError("holds vertices or faces that are none")
    if faces.shape[1] < 3:
        raise MeshError("has faces of fewer than three corners")
    # Polygons as fans
    fans = [faces[:, [0, k, k + 1]] for k in range(1, faces.shape[1] - 1)]
    normals = parts.get("vertex_normals")
    if normals is not None and np.shape(normals) != vertices.shape:
        normals = None
    return Mesh(
        vertices, np.concatenate(fans).astype(np.int64), None if normals is None else np.array(normals, np.float64)
    )


def _ply(data: bytes) -> Mesh:
    from trimesh.exchange.ply import load_ply

    end = re.search(rb"^[^\n]*(?<!\S)end_header(?!\S)", data, re.MULTILINE)
    if not end:
        raise MeshError("is cut short in its PLY header")
    header = data[: end.start()]
    elements = re.findall(rb"^element[ \t]+(\S+)[ \t]+(\d{1,18})\s*$", header, re.MULTILINE)
    # Of others trimesh would have its own idea.
    if len(elements) != len(re.findall(rb"^[^\S\n]*\S*element", header, re.MULTILINE)):
        raise MeshError("has an element in its PLY header that is none")
    lengths = {name: int(length) for name, length in elements}
    # Every element takes a byte at least, in text as in binary.
    if sum(lengths.values()) > len(data):
        raise MeshError("is cut short: its header announces more than follows")
    _check_counts(lengths.get(b"face", 0), lengths.get(b"vertex", 0))
    # Of text that is no number trimesh would read what comes before.
    if re.search(rb"^format[ \t]+ascii", header, re.MULTILINE) and re.search(rb"[^\d\seE+.-]", data[end.end() :]):
        raise MeshError("has something else than numbers after its PLY header")
    parts = load_ply(io.BytesIO(data), skip_materials=True, fix_texture=False)
    faces = parts["metadata"]["_ply_raw"].get("face", {}).get("data")
    if isinstance(faces, np.ndarray):
        # Of binary lists trimesh looks at the first one's length only.
        for name in faces.dtype.names or ():
            field = faces[name]
            if field.dtype.names and len(field) and (field["f0"] != field["f0"][0]).any():
                raise MeshError("mixes polygons of several sizes in a binary PLY file; triangulate it")
    for element, field in ((b"vertex", parts.get("vertices")), (b"face", parts.get("faces"))):
        if field is not None and len(field) < lengths.get(element, 0):
            raise MeshError(f"is cut short: its header announces {lengths[element]} of {element.decode()}")
    return _mesh(parts)


def _obj(data: bytes) -> Mesh:
    from trimesh.exchange.obj import load_obj

    text = data.replace(b"\r\n", b"\n").replace(b"\\\n", b" ")
    _check_lines(text)
    found = load_obj(io.BytesIO(text), skip_materials=True)
    meshes = [_mesh(parts) for parts in found.get("geometry", {}).values()]
    return _together(meshes)


def _check_lines(text: bytes) -> None:
    """Refuses lines of numbers that are none: trimesh would read what comes before the fault."""
    wrong = _BAD_LINE.search(text)
    if wrong is None:
        return
    line = text[wrong.start() :].split(b"\n", 1)[0].decode("latin-1")
    if re.search(r"^f\b.*-\d", line):
        raise MeshError("counts vertices back from the end (negative indices); export it with absolute ones")
    raise MeshError(f"has a line that is no vertex or face: {quoted(line)}")


class _Folder(Mapping[str, bytes]):
    """What trimesh asks for the files that a glTF file names: those in its folder or below, and no others."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()

    def __getitem__(self, uri: str) -> bytes:
        name = unquote(uri)
        path = (self.folder / name).resolve()
        if "\0" in name or "://" in name or not path.is_relative_to(self.folder):
            raise MeshError(f"names a buffer outside its folder: {quoted(uri)}")
        try:
            return _bytes(path)
        except OSError as error:
            raise MeshError(f"names a buffer that cannot be read, {quoted(uri)}: {error.strerror}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(())  # what there is is asked for by name only

    def __len__(self) -> int:
        return 0


def _gltf(data: bytes, folder: Path) -> Mesh:
    import trimesh
    from trimesh.exchange import gltf

    binary = data.startswith(b"glTF")
    text = data[20 : 20 + int.from_bytes(data[12:16], "little")] if binary else data
    tree = json.loads(text.decode("utf-8"))  # of any other encoding trimesh would have its own idea
    if tree.get("extensionsRequired"):
        raise MeshError(f"needs extensions of glTF: {quoted(', '.join(map(str, tree['extensionsRequired'])))}")
    for accessor in tree.get("accessors", ()):
        if "sparse" in accessor or "bufferView" not in accessor:
            raise MeshError("has sparse or empty accessors; export it without")
    _check_amounts(tree)
    load = gltf.load_glb if binary else gltf.load_gltf
    found = load(io.BytesIO(data), resolver=_Folder(folder), skip_materials=True)
    return _together(list(_placed(found, trimesh)))


#: Bytes of a number, and numbers of an item.
_COMPONENTS = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_ITEMS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_STRIP = 5  # the mode of primitives of which each corner but two makes a triangle


def _check_amounts(tree: Any) -> None:
    """Refuses a glTF file whose parts come to more than a mesh may have: they can name the same bytes over and over."""
    nodes, accessors = tree.get("nodes", ()), tree.get("accessors", ())
    counts = [accessor["count"] for accessor in accessors]
    lengths = [view["byteLength"] for view in tree.get("bufferViews", ())]
    if not all(type(number) is int and number > 0 for number in counts + lengths):
        raise MeshError("has a damaged accessor or buffer view")
    sizes = [_COMPONENTS[accessor["componentType"]] * _ITEMS[accessor["type"]] for accessor in accessors]
    unpacked = sum(count * size for count, size in zip(counts, sizes, strict=True))
    if max(sum(lengths), unpacked) > MAX_BYTES:
        raise MeshError(f"has accessors or buffer views of more than {MAX_BYTES} bytes together")
    children = [child for node in nodes for child in node.get("children", ())]
    if len(children) != len(set(children)):
        raise MeshError("has a node that is the child of several")
    uses = Counter(node["mesh"] for node in nodes if "mesh" in node)
    faces = vertices = 0
    for index, mesh in enumerate(tree.get("meshes", ())):
        times = max(1, uses[index])
        for primitive in mesh["primitives"]:
            points = primitive["attributes"]["POSITION"]
            corners = counts[primitive.get("indices", points)]
            faces += times * (corners if primitive.get("mode") == _STRIP else corners // 3)
            vertices += times * counts[points]
    _check_counts(faces, vertices)


def _placed(found: Mapping[str, Any], trimesh: Any) -> Iterator[Mesh]:
    """The scene's meshes where its nodes place them."""
    graph = trimesh.scene.transforms.SceneGraph(base_frame=found["base_frame"])
    for edge in found["graph"]:
        graph.update(**edge)
    for node in graph.nodes_geometry:
        matrix, name = graph.get(node)
        matrix = np.asarray(matrix, np.float64)
        mesh = _mesh(found["geometry"][name])
        if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix[:3, :3])) < 1e-300:
            raise MeshError("places a mesh by a matrix that is singular")
        mirrors = np.linalg.det(matrix[:3, :3]) < 0
        normals = None if mesh.normals is None else mesh.normals @ np.linalg.inv(matrix[:3, :3])
        faces = mesh.faces[:, ::-1] if mirrors else mesh.faces
        yield Mesh(mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3], faces, normals)


def _together(meshes: list[Mesh]) -> Mesh:
    """All meshes in one; those without normals get zeros where others have some."""
    if not meshes:
        raise MeshError("holds no triangle")
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    smooth = any(mesh.normals is not None for mesh in meshes)
    normals = [np.zeros_like(mesh.vertices) if mesh.normals is None else mesh.normals for mesh in meshes]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]),
        np.concatenate(normals) if smooth else None,
    )
