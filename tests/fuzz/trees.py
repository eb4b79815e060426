"""Tree files as `fl.load` reads them: a tree that is accepted answers as brute force does, and none crashes a query."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from claims import made_or_refused, require, same_bits
from comparisons import folder

import fastlines as fl

#: The columns of lists of hits.
_COLUMNS = ("offsets", "t", "prim", "u", "distance", "t_out")


def seeds() -> list[bytes]:
    """Small trees over each kind of geometry, with and without a layout."""
    return [tree_bytes(geometry, layout=layout, **more) for geometry, layout, more in _cases()]


def _cases() -> Iterator[tuple[Any, bool, dict[str, Any]]]:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(8, 3)).round(2)
    plain = fl.Lines.from_points(points, [5, 3])
    rich = fl.Lines.from_points(points, [5, 3], radius=np.linspace(0.1, 0.3, 8), attributes={"a": range(8)})
    curves = fl.Curves.from_bezier(points.reshape(2, 4, 3), radius=0.1, tolerance=0.5)
    triangles = fl.Triangles.from_mesh(points[:4], [[0, 1, 2], [1, 2, 3]])
    spheres = fl.Spheres.from_centres(points[:3], 0.2)
    yield plain, False, {}
    yield plain, True, {"builder": "kd-d2"}
    for geometry in (rich, curves, triangles, spheres, fl.Geometry([plain, spheres])):
        yield geometry, geometry is rich, {}


def tree_bytes(geometry: Any, *, layout: bool, builder: str = "bvh-cl") -> bytes:
    """Return the file of a tree."""
    path = folder() / "seed.flt"
    fl.build(geometry, builder).save(path, layout=layout)
    return path.read_bytes()


def run(data: bytes, choice: int, compares: bool | None) -> bool:
    """Load a tree; compare its answers with brute force, unless a saved layout may make them wrong."""
    path = folder() / "a.flt"
    path.write_bytes(data)
    tree = made_or_refused(lambda: fl.load(path, verify=False if choice & 1 else None))
    if isinstance(tree, fl.FastlinesError):
        return False
    if compares is not False:
        refused = made_or_refused(lambda: compare(tree, choice))
        require(not isinstance(refused, fl.FastlinesError), f"a query is refused: {refused}")
    return True


def compare(tree: fl.Tree, choice: int) -> None:
    """Compare answers with brute force, where neither a frame of its own nor a saved layout makes them others."""
    rng = np.random.default_rng(choice)
    low, high = np.asarray(tree.geometry.bounds if len(tree.geometry) else np.zeros((2, 3)), np.float64)
    size = max(float((high - low).max()), 1e-6)
    targets = low + (high - low) * rng.random((24, 3))
    origins = low + (high - low) * rng.uniform(-0.5, 1.5, (24, 3))
    directions = np.where(targets == origins, 1.0, targets - origins)
    radius = size * rng.choice([0, 1e-3, 0.1]) if tree.geometry.takes_radius else None
    is_forged = "layout" in tree.__dict__
    found = tree.all_hits(origins, directions, radius)
    tree.first_hit(origins, directions, radius)
    if is_forged or tree.frame is not None:
        return
    expected = fl.brute_force(tree.geometry, origins, directions, radius)
    for name in _COLUMNS:
        require(
            same_bits(getattr(found, name), getattr(expected, name)), f"{name} of hits are not those of brute force"
        )
