"""Hair in Blender whose strands come too near to each other: `python examples/blender_hair.py near.blend groom.blend`.

Finds strands whose surfaces are within a clearance, and writes two attributes of curves: ``near_strands``, how many
others come that near, and ``gap``, the distance to the nearest of them, which is negative where strands penetrate each
other. Geometry Nodes and materials can select by both. Without a second file, a small groom is made.

Needs ``pip install bpy`` and the Python version that bpy is for, or Blender itself, whose Python needs fastlines:
``blender --background groom.blend --python examples/blender_hair.py -- near.blend``. Tested with bpy 5.0.
"""

import sys
from typing import Any

import bpy
import numpy as np

import fastlines as fl


def hair_objects() -> list[Any]:
    """Return the objects of hair curves that have strands."""
    return [thing for thing in bpy.data.objects if thing.type == "CURVES" and len(thing.data.curves)]


def make_groom(n_strands: int = 200, n_points: int = 12) -> None:
    """Add an object of curly strands on a disc, which is turned and scaled."""
    rng = np.random.default_rng(1)
    root = np.sqrt(rng.uniform(0, 1, (n_strands, 1, 1))) * np.exp(2j * np.pi * rng.uniform(0, 1, (n_strands, 1, 1)))
    t = np.linspace(0, 1, n_points)[None, :, None]
    curl = 0.12 * t * np.exp(2j * np.pi * (2 * t + rng.uniform(0, 1, (n_strands, 1, 1))))
    across = root + curl
    points = np.concatenate([across.real, across.imag, np.broadcast_to(1.5 * t, across.shape)], axis=2)
    data = bpy.data.hair_curves.new("groom")
    data.add_curves([n_points] * n_strands)
    data.attributes["position"].data.foreach_set("vector", points.astype(np.float32).reshape(-1))
    radius = data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.tile(np.linspace(0.01, 0.002, n_points, dtype=np.float32), n_strands))
    groom = bpy.data.objects.new("groom", data)
    groom.scale, groom.rotation_euler = (2, 2, 2), (0.3, 0, 0)
    bpy.context.scene.collection.objects.link(groom)
    bpy.context.view_layer.update()  # which computes the matrix of the object


def lines_of(hair: Any) -> fl.Lines:
    """Return the control points of strands as polylines in the world, with their radii."""
    data, n = hair.data, len(hair.data.points)
    points = np.empty(3 * n, np.float32)
    data.attributes["position"].data.foreach_get("vector", points)
    radius = np.zeros(n, np.float32)
    if "radius" in data.attributes:
        data.attributes["radius"].data.foreach_get("value", radius)
    offsets = np.empty(len(data.curves) + 1, np.int32)
    data.curve_offset_data.foreach_get("value", offsets)
    matrix = np.array(hair.matrix_world)
    scale = np.cbrt(abs(np.linalg.det(matrix[:3, :3])))
    in_world = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    return fl.Lines.from_points(in_world, np.diff(offsets), radius=radius * scale)


def near_strands(parts: list[fl.Lines], clearance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return for each strand of all parts how many others come near, and the distance to the nearest of them."""
    first = np.cumsum([0, *(part.n_strands for part in parts)])
    strands = np.concatenate([part.strands + at for part, at in zip(parts, first[:-1], strict=True)])
    lines = fl.Lines.from_segments(
        np.concatenate([part.segments for part in parts]),
        strands=strands,
        radius=np.concatenate([part.radius for part in parts]),
    )
    pairs = fl.build(lines).pairs(clearance, skip_strand=True)
    both = np.sort(np.stack([strands[pairs.i], strands[pairs.j]], axis=1), axis=1)
    gap = np.full(first[-1], clearance, np.float32)
    np.minimum.at(gap, both, pairs.distance[:, None])
    return np.bincount(np.unique(both, axis=0).reshape(-1), minlength=first[-1]), gap


def write(hair: Any, name: str, kind: str, values: np.ndarray) -> None:
    """Write an attribute of the curves of an object."""
    attributes = hair.data.attributes
    if name in attributes:
        attributes.remove(attributes[name])
    attributes.new(name, kind, "CURVE").data.foreach_set("value", values)


def main(path: str, source: str = "", clearance: float = 0.01) -> None:
    """Write a file of Blender in which strands have the two attributes."""
    if source:
        bpy.ops.wm.open_mainfile(filepath=source)
    if not hair_objects():
        make_groom()
    objects = hair_objects()
    parts = [lines_of(hair) for hair in objects]
    near, gap = near_strands(parts, clearance)
    ends = np.cumsum([part.n_strands for part in parts])[:-1]
    for hair, counts, gaps in zip(objects, np.split(near, ends), np.split(gap, ends), strict=True):
        write(hair, "near_strands", "INT", counts.astype(np.int32))
        write(hair, "gap", "FLOAT", gaps)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    print(f"{path}: {(near > 0).sum()} of {len(near)} strands come within {clearance:g} of another one")


if __name__ == "__main__":
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    main(*given[:2], *map(float, given[2:]))
