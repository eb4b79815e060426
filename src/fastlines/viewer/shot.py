"""A ray that is shot into one tree or two: its way through them, its hits, and tables of both."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..camera import Vector
from ..errors import InputError
from ..geometry.hit_places import Float64Array
from ..inspection.one_ray import check_ray
from ..inspection.outline import Outline
from ..inspection.slabs import enter
from ..inspection.traversal import Traversal
from ..query.hits import AllHits
from ..rendering.looks.color import ATTRIBUTE
from ..support.texts import counted, number_text
from ..tree import Tree
from .line_colors import numeric_attributes
from .tables import Table

#: The most hits in the table, and the most attributes.
MAX_LISTED, MAX_ATTRIBUTES = 30, 4
#: The columns of that table; an attribute with one of these names is shown as "attribute:name".
COLUMNS = ("hit", "part", "prim", "strand", "t", "distance")
#: The most hits of a ray that is followed, so that the page answers soon.
MAX_HITS = 100_000
#: The most boxes of visited nodes, and the most points of hits, on the page.
MAX_VISITED, MAX_POINTS = 2_000, 20_000
#: How far the ray is drawn beyond the box of everything, as a fraction of its longest side.
BEYOND = 0.1


@dataclass(frozen=True)
class Ray:
    """A ray, in the coordinates of `Tree.all_hits`."""

    origin: Vector
    direction: Vector


def make_ray(tree: Tree, origin: npt.ArrayLike, direction: npt.ArrayLike, radius: float) -> Ray:
    """Return a ray that queries of a tree take.

    Raises
    ------
    InputError
        If `Tree.all_hits` refuses it.
    """
    start, along = check_ray(origin, direction)
    tree.any_hit(start, along, radius)
    (x, y, z), (dx, dy, dz) = start.tolist(), along.tolist()
    return Ray((x, y, z), (dx, dy, dz))


def rounded(values: Sequence[float] | Float64Array, size: float) -> Vector:
    """Return three numbers to a millionth of some size, so that the panel shows short ones.

    Examples
    --------
    >>> rounded([1 / 3, 4500000.1234567, -1e-9], 1.0)
    (0.333333, 4500000.123457, -0.0)
    """
    x, y, z = (round(float(value), 6 - math.floor(math.log10(size))) for value in values)
    return x, y, z


def vector_text(values: Sequence[float]) -> str:
    """Return three numbers as a text that `read_vector` reads back to the bit.

    Examples
    --------
    >>> vector_text((0.5, 2.0, -1e-09))
    '0.5, 2, -1e-09'
    """
    return ", ".join(repr(float(value)).removesuffix(".0") for value in values)


def read_vector(text: str, name: str) -> Vector:
    """Read three numbers separated by commas or spaces.

    Raises
    ------
    InputError
        If the text is anything else, or one is not finite.

    Examples
    --------
    >>> read_vector("0.5, 2, -1e-9", "origin")
    (0.5, 2.0, -1e-09)
    """
    try:
        x, y, z = (float(part) for part in text.replace(",", " ").split())
    except ValueError:
        raise InputError(f"{name} {text!r} is not three numbers, such as 0.5, 2, -1") from None
    if not all(map(math.isfinite, (x, y, z))):
        raise InputError(f"{name} {text!r} is not finite; expected three finite numbers")
    return x, y, z


def radius_text(radius: float) -> str:
    """Return a radius as a text that `read_radius` reads."""
    return repr(float(radius)).removesuffix(".0")


def read_radius(text: str) -> float:
    """Read a radius, to the last digit.

    Raises
    ------
    InputError
        If the text is no number from 0.

    Examples
    --------
    >>> read_radius("0.0005"), radius_text(0.0005)
    (0.0005, '0.0005')
    """
    try:
        radius = float(text)
    except ValueError:
        radius = math.nan
    if not 0 <= radius < math.inf:
        raise InputError(f"radius {text!r} is not a number from 0, such as 0.01")
    return radius


def hit_table(hits: AllHits, most: int = MAX_LISTED) -> Table:
    """Return a row for each hit: its number, prim, strand, t, distance and attributes, as `AllHits` has them.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[0, 0, 8], [1, 1, 9]]])
    >>> hit_table(tree.all_hits([[0.5, 0.5, -5]], [[0, 0, 1]], 0.1)).rows
    [['1', '0', '0', '5.5', '0'], ['2', '1', '1', '13.5', '0']]
    """
    geometry = hits.geometry
    n = min(len(hits), most)
    columns: list[tuple[str, Sequence[str]]] = [("hit", [str(i + 1) for i in range(n)])]
    if hits.part is not None:
        columns.append(("part", [str(part) for part in hits.part[:n]]))
    columns.append(("prim", [str(prim) for prim in hits.prim[:n]]))
    if geometry is not None and geometry.n_strands:
        columns.append(("strand", [str(strand) if strand >= 0 else "–" for strand in hits.strand[:n]]))
    columns.append(("t", [f"{t:.6g}" for t in hits.t[:n]]))
    columns.append(("distance", [f"{distance:.4g}" for distance in hits.distance[:n]]))
    names = () if geometry is None or not n else numeric_attributes(geometry)[:MAX_ATTRIBUTES]
    for name in names:
        values = np.asarray(hits.sample(name), np.float64)[:n]
        texts = ["NaN" if np.isnan(value).all() else _value_text(value) for value in values]
        columns.append((f"{ATTRIBUTE}{name}" if name in COLUMNS else name, texts))
    return Table(
        [name for name, _ in columns], [list(row) for row in zip(*(texts for _, texts in columns), strict=True)]
    )


def _value_text(value: npt.NDArray[np.float64]) -> str:
    return number_text(float(value)) if value.ndim == 0 else ", ".join(map(number_text, value.tolist()))


def hits_text(hits: AllHits, most: int = MAX_LISTED) -> str:
    """Return how many hits there are, and how many are listed."""
    listed = f"; the first {most} are listed" if len(hits) > most else ""
    return f"{counted(len(hits), 'hits')}{listed}"


def work_table(names: Sequence[str], ways: Sequence[Traversal], outlines: Sequence[Outline]) -> Table:
    """Return what the ray costs in each tree, a row for each, beside the cost of the tree: the mean over all lines."""
    rows = []
    for name, way, outline in zip(names, ways, outlines, strict=True):
        work = f"{way.n_steps:,}", f"{way.n_tests:,}", f"{way.cost:.6g}", f"{len(way.hits):,}"
        rows.append([name, *work, f"{outline.cost_below[0]:.6g}"])
    return Table(["tree", "steps", "tests", "cost of the ray", "hits", "cost of the tree"], rows)


def step_text(way: Traversal, outline: Outline, step: int) -> str:
    """Return what the ray does at one step, counted from 1."""
    if not len(way.nodes):
        return "the ray misses the box of the root"
    if step <= 0:
        return "before the first node"
    i = min(step, len(way.nodes)) - 1
    node = int(way.nodes[i])
    what = f"leaf {node}, {counted(int(outline.n_refs[node]), 'tests')}, {counted(int(way.n_found[i]), 'hits')}"
    if not way.is_leaf[i]:
        what = f"inner node {node}"
    return f"step {i + 1} of {len(way.nodes)}: {what}, level {outline.level[node]}, entered at t = {way.enter[i]:.6g}"


def ray_ends(ray: Ray, box: Float64Array, stop: float | None = None) -> Float64Array | None:
    """Return the part of a ray that is drawn, (2, 3): from near a box to beyond it, or to t = `stop`.

    It is None for a ray that misses the box.

    Examples
    --------
    >>> ray_ends(Ray((0.5, 0.5, -5.0), (0.0, 0.0, 1.0)), np.array([[0.0, 0, 0], [1, 1, 1]]))[:, 2].round(6).tolist()
    [-0.1, 1.1]
    """
    origin, direction = np.array(ray.origin), np.array(ray.direction)
    beyond = BEYOND * float((box[1] - box[0]).max()) / float(np.sqrt((direction**2).sum()))
    first = float(enter(box[None], origin, direction, 0.0)[0])
    if not math.isfinite(first):
        return None
    # The ray leaves the box where one from its other side enters it.
    far = first + 2 * float((box[1] - box[0]).sum()) / float(np.abs(direction).max())
    last = far - float(enter(box[None], origin + far * direction, -direction, 0.0)[0])
    end = last + beyond if stop is None else stop
    return np.stack([origin + max(0.0, first - beyond) * direction, origin + end * direction])
