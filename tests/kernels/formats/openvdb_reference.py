"""Run by Debian's own python3, which has OpenVDB: `openvdb_reference.py write DIR` writes test files with the library,
`openvdb_reference.py dump FILE.vdb...` writes beside each file what the library reads in it, as FILE.npz.

For grid number i of FILE.npz: `name_i`, `values_i` (indexed [x][y][z], float32), `low_i` (position of the first),
`matrix_i` (index to world, 4×4 for column vectors), `voxels_i` (active) and `shape_i` (of their bounding box).
"""

import random
import sys
from pathlib import Path

import numpy as np
import pyopenvdb as vdb

MARGIN = 3
SMALL = 1_500_000  # bytes: only in smaller files every inactive value is looked at, which is slow


def noise(grid, low, high, count, inactive=0):
    """Sets `count` active voxels, and `inactive` ones, between two corners, the corners included."""
    rng = random.Random(str((low, high, count)))
    vector = isinstance(grid, vdb.Vec3SGrid)
    accessor = grid.getAccessor()
    for n in range(count + inactive):
        ijk = (low, high)[n] if n < 2 else tuple(rng.randint(a, b) for a, b in zip(low, high, strict=True))
        value = tuple(rng.gauss(0, 1) for _ in range(3)) if vector else rng.gauss(0, 1)
        if n < count:
            accessor.setValueOn(ijk, value)
        elif not accessor.isValueOn(ijk):
            accessor.setValueOff(ijk, value)
    return grid


def named(grid, name, fog=True):
    grid.name = name
    if fog:
        grid.gridClass = vdb.GridClass.FOG_VOLUME
    return grid


def write(folder):
    def save(stem, *grids, metadata=None):
        vdb.write(str(folder / f"{stem}.vdb"), grids=list(grids), metadata=metadata)

    save("sparse", named(noise(vdb.FloatGrid(), (-300, -20, -5000), (150, 30, -4980), 3000), "density"))
    save("origin", named(noise(vdb.FloatGrid(), (-1, -1, -1), (0, 0, 0), 8), "density"))
    save("one_voxel", named(noise(vdb.FloatGrid(), (-8, 7, 4095), (-8, 7, 4095), 1), "density"))
    save("empty", named(vdb.FloatGrid(), "density"))

    half = named(noise(vdb.FloatGrid(), (-40, 3, 9), (60, 50, 12), 4000, inactive=300), "density", fog=False)
    half.saveFloatAsHalf = True
    save("half", half)
    save("vector", named(noise(vdb.Vec3SGrid(), (-9, -9, -9), (30, 5, 20), 900, inactive=40), "velocity", fog=False))
    half = named(noise(vdb.Vec3SGrid(), (-9, -9, -9), (30, 5, 20), 900), "velocity", fog=False)
    half.saveFloatAsHalf = True
    save("vector_half", half)
    save("inactive", named(noise(vdb.FloatGrid(), (-70, -2, 5), (9, 60, 30), 500, inactive=500), "density", fog=False))

    tiles = vdb.FloatGrid()
    tiles.fill((-128, 0, 0), (-1, 127, 127), 0.5)  # a tile of 128³
    tiles.fill((0, 0, 0), (20, 15, 8), 0.1)  # tiles of 8³ and leaves
    tiles.fill((0, 40, 0), (7, 47, 7), 0.25, active=False)
    tiles.fill((0, 200, 0), (7, 207, 7), 0.0)  # active, yet nothing
    save("tiles", named(tiles, "density"))
    half = named(tiles.deepCopy(), "density", fog=False)
    half.saveFloatAsHalf = True
    save("tiles_half", half)
    root = vdb.FloatGrid()
    root.fill((0, 0, 0), (4095, 4095, 4095), 1.0)
    save("root_tile", named(root, "density"))
    far = noise(noise(vdb.FloatGrid(), (-100000,) * 3, (-100000,) * 3, 1), (100000,) * 3, (100000,) * 3, 1)
    save("far", named(far, "density"))

    maps = {"uniform_scale": [("scale", 0.25)]}
    maps["uniform_scale_translate"] = [("scale", 0.25), ("translate", (1, -2, 3))]
    maps["scale"] = [("scale", (1, -2, 0.5))]
    maps["scale_translate"] = [("scale", (1, -2, 0.5)), ("translate", (1, -2, 3))]
    maps["affine"] = [("scale", (1, 2, 0.5)), ("rotate", 0.3), ("shear", 0.2), ("translate", (4, 5, 6))]
    for stem, steps in maps.items():
        transform = vdb.createLinearTransform(1.0)
        for step, value in steps:
            axes = {"rotate": (vdb.Axis.Y,), "shear": (vdb.Axis.X, vdb.Axis.Z)}.get(step, ())
            getattr(transform, step)(value, *axes)
        grid = named(noise(vdb.FloatGrid(), (-5, 0, 7), (5, 9, 19), 60), "density")
        grid.transform = transform
        save(f"map_{stem}", grid)
    frustum = named(noise(vdb.FloatGrid(), (0, 0, 0), (9, 9, 9), 50), "density")
    frustum.transform = vdb.createFrustumTransform((0, 0, 0), (10, 10, 10), 0.5, 1.0, 0.1)
    save("map_frustum", frustum)

    first = named(noise(vdb.FloatGrid(), (0, 0, 0), (20, 9, 9), 200), "heat")
    second = named(noise(vdb.FloatGrid(), (-9, 4, 0), (2, 9, 30), 300), "density")
    instance = named(first.copy(), "fuel")
    instance.transform = vdb.createLinearTransform(2.0)
    kinds = {"a": True, "b": 1.5, "c": 7, "d": "text", "e": (1, 2), "f": (1, 2, 3), "g": (0.5, 1.5), "h": (0.5, 1, 2)}
    save("several", first, second, instance, metadata=kinds)
    save("no_density", named(first.deepCopy(), "a"), named(second.deepCopy(), "b"))
    save("same_name", named(first.deepCopy(), "a"), named(second.deepCopy(), "a"))
    save("level_set", named(vdb.createLevelSetSphere(5.0), "surface", fog=False))
    save("background", named(noise(vdb.FloatGrid(1.0), (0, 0, 0), (9, 9, 9), 20), "density"))
    flags = vdb.BoolGrid()
    flags.fill((0, 0, 0), (9, 8, 7), True)
    save("bool", named(flags, "flags"), named(second.deepCopy(), "density"))


def dump(path):
    arrays = {}
    for n, grid in enumerate(vdb.readAll(str(path))[0]):
        corners = [grid.evalLeafBoundingBox()] if grid.leafCount() else []
        if grid.activeVoxelCount():
            corners.append(grid.evalActiveVoxelBoundingBox())
        if path.stat().st_size < SMALL:
            zero = grid.background
            corners += [(item.min, item.max) for item in grid.citerOffValues() if item.value != zero]
        low = np.min([a for a, _ in corners], axis=0) - MARGIN if corners else np.zeros(3, int)
        high = np.max([b for _, b in corners], axis=0) + MARGIN if corners else np.ones(3, int)
        channels = (3,) if isinstance(grid, vdb.Vec3SGrid) else ()
        values = np.empty((*(high - low + 1), *channels), np.float32)
        grid.copyToArray(values, ijk=tuple(int(n) for n in low))
        origin = np.array(grid.transform.indexToWorld((0, 0, 0)))
        matrix = np.eye(4)
        matrix[:3, 3] = origin
        for axis in range(3):
            matrix[:3, axis] = np.array(grid.transform.indexToWorld(tuple(np.eye(3)[axis]))) - origin
        arrays[f"name_{n}"] = grid.name
        arrays[f"values_{n}"], arrays[f"low_{n}"], arrays[f"matrix_{n}"] = values, low, matrix
        arrays[f"voxels_{n}"] = grid.activeVoxelCount()
        arrays[f"shape_{n}"] = grid.evalActiveVoxelDim() if grid.activeVoxelCount() else (0, 0, 0)
    np.savez(path.with_suffix(".npz"), **arrays)


if __name__ == "__main__":
    if sys.argv[1] == "write":
        write(Path(sys.argv[2]))
    else:
        for argument in sys.argv[2:]:
            dump(Path(argument))
