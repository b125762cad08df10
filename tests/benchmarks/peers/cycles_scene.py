"""A scene for Blender Cycles, made in bpy's current one. What is not translated raises Skip."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np
from protocol import Job, Skip

bpy.utils.expose_bundled_modules()
import bmesh  # noqa: E402  it is there once bpy is
import openvdb  # noqa: E402  it is one of the bundled modules

Array = np.ndarray


def make_scene(job: Job) -> None:
    """Camera, media, surfaces and lights; grids of OpenVDB in the job's folder."""
    scene = job.scene
    _camera(scene["camera"])
    for volume in scene["volumes"]:
        _VOLUMES[volume["kind"]](volume, job)
    for surface in scene["surfaces"]:
        _surface(surface)
    _world([light for light in scene["lights"] if light["kind"] == "constant"])
    for light in scene["lights"]:
        if light["kind"] != "constant":
            _light(light)


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)


def _looking(origin: list[float], forward: Array, up: Array) -> Array:
    """4 × 4 of a camera or a light: it looks along its -z, +y is up."""
    forward = _unit(forward)
    right = _unit(np.cross(forward, up))
    placed = np.eye(4)
    placed[:3] = np.stack([right, np.cross(right, forward), -forward, origin], axis=1)
    return placed


def _place(name: str, data: Any, to_world: Array) -> Any:
    placed = bpy.data.objects.new(name, data)
    placed.matrix_world = to_world.T.tolist()  # column by column
    bpy.context.scene.collection.objects.link(placed)
    return placed


def _camera(camera: dict[str, Any]) -> None:
    data = bpy.data.cameras.new("camera")
    origin, target = np.array(camera["origin"]), np.array(camera["target"])
    data.sensor_fit = "VERTICAL"
    data.clip_start, data.clip_end = 1e-3, 1e6
    match camera["kind"]:
        case "perspective":
            data.type, data.angle = "PERSP", math.radians(camera["fov"])
        case "orthographic":
            data.type, data.ortho_scale = "ORTHO", camera["height"]
        case kind:
            raise Skip(f"cameras of the kind {kind} are not translated")
    placed = _place("camera", data, _looking(camera["origin"], target - origin, np.array(camera["up"])))
    bpy.context.scene.camera = placed


def _colour(value: float | list[float]) -> Array:
    return np.broadcast_to(np.asarray(value, float), 3)


def _world(lights: list[dict[str, Any]]) -> None:
    world = bpy.context.scene.world = bpy.data.worlds.new("world")
    world.node_tree.nodes.clear()
    background = world.node_tree.nodes.new("ShaderNodeBackground")
    radiance = sum((_colour(light["radiance"]) for light in lights), np.zeros(3))
    background.inputs["Color"].default_value = (*radiance, 1)
    output = world.node_tree.nodes.new("ShaderNodeOutputWorld")
    world.node_tree.links.new(background.outputs["Background"], output.inputs["Surface"])


def _light(light: dict[str, Any]) -> None:
    match light["kind"]:
        case "directional":
            data = bpy.data.lights.new("sun", "SUN")
            data.angle = 0
            energy = _colour(light["irradiance"])
            origin, forward = [0.0, 0.0, 0.0], np.array(light["direction"], float)
        case "spot":
            data = bpy.data.lights.new("spot", "SPOT")
            data.shadow_soft_size = 0
            # Watts in all directions.
            energy = 4 * math.pi * _colour(light["intensity"])
            cutoff, beam = (math.radians(light[name]) for name in ("cutoff", "beam"))
            data.spot_size = 2 * cutoff
            data.spot_blend = (math.cos(beam) - math.cos(cutoff)) / (1 - math.cos(cutoff))
            origin, forward = light["position"], np.subtract(light["target"], light["position"])
        case kind:
            raise Skip(f"lights of the kind {kind} are not translated")
    data.energy = energy.max()
    data.color = energy / energy.max()
    up = np.eye(3)[np.argmin(np.abs(forward))]
    _place(light["kind"], data, _looking(origin, forward, up))


class _Shader:
    """A material, node by node."""

    def __init__(self) -> None:
        self.material = bpy.data.materials.new("material")
        self._tree = self.material.node_tree
        self._tree.nodes.clear()

    def node(self, kind: str, inputs: dict[Any, Any], **properties: Any) -> Any:
        """A node; an input is a value or the output of another node."""
        node = self._tree.nodes.new(f"ShaderNode{kind}")
        for name, value in properties.items():
            setattr(node, name, value)
        for key, value in inputs.items():
            if isinstance(value, bpy.types.NodeSocket):
                self._tree.links.new(value, node.inputs[key])
            else:
                node.inputs[key].default_value = value
        return node

    def volume(self, volume: dict[str, Any], absorption: Any, scatter: Any, emission: Any) -> Any:
        """The medium's coefficients, inverse scene units and radiance a scene unit."""
        phase = volume["phase"]
        if phase["kind"] not in ("isotropic", "henyey_greenstein"):
            raise Skip(f"phase functions of the kind {phase['kind']} are not translated")
        coefficients = {"Absorption": absorption, "Scatter": scatter, "Emission": emission}
        inputs = {f"{name} Coefficients": value for name, value in coefficients.items()}
        node = self.node("VolumeCoefficients", {**inputs, "Anisotropy": phase.get("g", 0.0)}, phase="HENYEY_GREENSTEIN")
        self.node("OutputMaterial", {"Volume": node.outputs[0]})
        return self.material


def _ball(center: list[float], radius: float) -> Any:
    """A mesh of 81 920 triangles, of the ball's volume; it is off the sphere by at most 4e-5 of the radius."""
    mesh = bpy.data.meshes.new("ball")
    made = bmesh.new()
    bmesh.ops.create_icosphere(made, subdivisions=7, radius=1)
    bmesh.ops.scale(made, verts=made.verts, vec=[radius * (4 * math.pi / 3 / made.calc_volume()) ** (1 / 3)] * 3)
    bmesh.ops.translate(made, verts=made.verts, vec=center)
    made.to_mesh(mesh)
    made.free()
    return mesh


def _box(low: list[float], high: list[float]) -> Any:
    mesh = bpy.data.meshes.new("box")
    made = bmesh.new()
    bmesh.ops.create_cube(made, size=1)
    bmesh.ops.scale(made, verts=made.verts, vec=np.subtract(high, low))
    bmesh.ops.translate(made, verts=made.verts, vec=np.add(low, high) / 2)
    made.to_mesh(mesh)
    made.free()
    return mesh


def _constant(volume: dict[str, Any], job: Job) -> None:
    shape, to_world = volume["shape"], np.eye(4)
    match shape["kind"]:
        case "sphere":
            mesh = _ball(shape["center"], shape["radius"])
        case "box":
            mesh, to_world = _box(shape["min"], shape["max"]), np.array(shape["to_world"])
        case kind:
            raise Skip(f"media in shapes of the kind {kind} are not translated")
    if volume["emission"]:
        raise Skip("homogeneous media that emit are not translated")
    sigma_t, albedo = _colour(volume["sigma_t"]), _colour(volume["albedo"])
    mesh.materials.append(_Shader().volume(volume, sigma_t * (1 - albedo), sigma_t * albedo, (0, 0, 0)))
    _place("medium", mesh, to_world)


def _grid(volume: dict[str, Any], job: Job) -> None:
    if volume["albedo_grid"] or volume["interpolation"] != "trilinear":
        raise Skip("grids of the albedo and without interpolation are not translated")
    density, to_scene = job.values(volume["file"]), job.to_scene(volume["file"])
    grids, emission = [_vdb("density", density, to_scene)], volume["emission"]
    if emission:
        if emission["kind"] != "grid":
            raise Skip(f"emission of the kind {emission['kind']} is not translated")
        grids.append(_vdb("emission", job.values(emission["file"]), job.to_scene(emission["file"])))
    file = job.folder / f"{volume['file']}.cycles.vdb"
    openvdb.write(str(file), grids)

    shader = _Shader()
    inside = None if all(_ends(job.values(name)) for name in job.grids) else _inside(shader, to_scene)

    def coefficient(name: str, output: str, scale: Array) -> Any:
        value = shader.node("Attribute", {}, attribute_name=name).outputs[output]
        if inside is not None:
            value = shader.node("VectorMath", {0: value, "Scale": inside}, operation="SCALE").outputs[0]
        return shader.node("VectorMath", {0: value, 1: scale}, operation="MULTIPLY").outputs[0]

    sigma_t, albedo = _colour(volume["scale"]), _colour(volume["albedo"])
    data = bpy.data.volumes.new("medium")
    data.filepath = str(file)
    data.render.precision, data.render.clipping = "FULL", 0
    data.materials.append(
        shader.volume(
            volume,
            coefficient("density", "Fac", sigma_t * (1 - albedo)),
            coefficient("density", "Fac", sigma_t * albedo) if albedo.any() else (0, 0, 0),
            coefficient("emission", "Vector", _colour(emission["scale"])) if emission else (0, 0, 0),
        )
    )
    _place("medium", data, np.eye(4))


def _ends(values: Array) -> bool:
    """Whether a grid is 0 at its ends, where it goes on at the same value for half a voxel, and OpenVDB's falls."""
    return not any(values.take(end, axis).any() for axis in range(3) for end in (0, -1))


def _vdb(name: str, values: Array, to_scene: Array) -> Any:
    """A grid of OpenVDB, one voxel wider at each end if it is not 0 there: its voxels' values lie at whole numbers."""
    n, pad = np.array(values.shape[2::-1]), 0 if _ends(values) else 1
    values = np.pad(values, [(pad, pad)] * 3 + [(0, 0)] * (values.ndim - 3), "edge")
    grid = openvdb.FloatGrid() if values.ndim == 3 else openvdb.Vec3SGrid()
    grid.copyFromArray(np.ascontiguousarray(np.swapaxes(values, 0, 2)), ijk=(-pad, -pad, -pad))
    voxel_to_cube = np.diag([*(1 / n), 1.0])
    voxel_to_cube[:3, 3] = 0.5 / n
    grid.transform = openvdb.createLinearTransform((to_scene @ voxel_to_cube).T.tolist())
    grid.name = name
    return grid


def _inside(shader: _Shader, to_scene: Array) -> Any:
    """1 in the parallelepiped that the grid fills, else 0."""
    if np.any(to_scene[:3, :3] != np.diag(to_scene.diagonal()[:3])):
        raise Skip("grids that do not end in 0 and are turned are not translated")
    point = shader.node("NewGeometry", {}).outputs["Position"]
    low, size = to_scene[:3, 3], to_scene.diagonal()[:3]
    if low.any() or np.any(size != 1):
        point = shader.node("VectorMath", {0: point, 1: 1 / size, 2: -low / size}, operation="MULTIPLY_ADD").outputs[0]
    cube = shader.node("VectorMath", {0: point}, operation="FLOOR").outputs[0]
    off = shader.node("VectorMath", {0: cube}, operation="LENGTH").outputs["Value"]
    return shader.node("Math", {0: off, 1: 0.5}, operation="LESS_THAN").outputs[0]


_VOLUMES = {"constant": _constant, "grid": _grid}


def _surface(surface: dict[str, Any]) -> None:
    shader, reflectance = _Shader(), surface["material"].get("reflectance")
    if surface["material"]["kind"] != "diffuse":
        raise Skip(f"materials of the kind {surface['material']['kind']} are not translated")
    lambert = shader.node("BsdfDiffuse", {"Color": (*_colour(reflectance), 1), "Roughness": 0})
    shader.node("OutputMaterial", {"Surface": lambert.outputs[0]})
    match surface["kind"]:
        case "rectangle":
            mesh = bpy.data.meshes.new("rectangle")
            mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
            mesh.materials.append(shader.material)
            _place("rectangle", mesh, np.array(surface["to_world"]))
        case "sphere":
            _sphere(surface["center"], surface["radius"], shader.material)
        case kind:
            raise Skip(f"surfaces of the kind {kind} are not translated")


def _sphere(center: list[float], radius: float, material: Any) -> None:
    """A point with a radius, which is an exact sphere to Cycles; nodes of geometry make one."""
    tree = bpy.data.node_groups.new("sphere", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    points = tree.nodes.new("GeometryNodePoints")
    points.inputs["Position"].default_value, points.inputs["Radius"].default_value = center, radius
    painted = tree.nodes.new("GeometryNodeSetMaterial")
    painted.inputs["Material"].default_value = material
    output = tree.nodes.new("NodeGroupOutput")
    tree.links.new(points.outputs[0], painted.inputs["Geometry"])
    tree.links.new(painted.outputs[0], output.inputs[0])
    placed = _place("sphere", bpy.data.meshes.new("sphere"), np.eye(4))
    placed.modifiers.new("sphere", "NODES").node_group = tree
