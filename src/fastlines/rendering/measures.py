"""Looks that show a number of each ray: how many lines it hits, their density, and how much work that is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..geometry.hit_places import Float64Array
from ..tree import Tree
from .looks.look import Backdrop
from .looks.table import NIGHT
from .node_visits import visited_nodes


@dataclass(frozen=True)
class Measure:
    """A number of each ray, shown by a colour map.

    Attributes
    ----------
    name : str
        Its key in `Picture.aovs`.
    title : str
        What the legend says.
    count : callable
        Takes a tree, the origins and the directions of rays, and the radius; returns a number for each ray, (n,).
    map : str
        The colour map.
    range : pair of floats, optional
        The numbers at both ends of the map; by default 0 and the 99 % quantile of the pixels that are not 0.
    backdrop : Backdrop
        What is behind pixels of 0.
    least_radius : float
        The least radius that a picture chooses, in pixels: with a smaller one, lines between two rays are missed.
    """

    name: str
    title: str
    count: Callable[[Tree, FloatArray, FloatArray, float], IntArray | Float64Array]
    map: str
    range: tuple[float, float] | None = None
    backdrop: Backdrop = NIGHT
    least_radius: float = 0.0


def _hits(tree: Tree, origins: FloatArray, directions: FloatArray, radius: float) -> IntArray:
    return tree.count_hits(origins, directions, radius)


def _density(tree: Tree, origins: FloatArray, directions: FloatArray, radius: float) -> Float64Array:
    lines = [part for part in tree.geometry.each_part() if part.has_directions]
    if not lines:
        raise InputError(
            f"look='density' shows the length of lines along rays, and there are only {tree.geometry.count_text()}; "
            "use look='hits'"
        )
    if radius == 0 and not any(part.max_radius > 0 for part in lines):
        raise InputError(
            "look='density' spreads each line over its radius, and radius=0 is none; pass a radius above 0"
        )
    return tree.gather(origins, directions, radius).sum


#: The measures by name.
MEASURES = {
    "hits": Measure("hits", "hits per ray", _hits, "viridis"),
    "density": Measure("density", "length of lines per area", _density, "gray", least_radius=1.0),
    "work": Measure("work", "nodes visited per ray", visited_nodes, "inferno"),
}
