"""``mesh.fastlines``: ray queries on the lines of a ``pyvista.PolyData``."""

from __future__ import annotations

import contextlib
from typing import Any

from ..builder import build
from ..errors import MissingExtraError
from ..geometry.lines import Lines
from ..geometry.making import Making
from ..geometry.offsets import NO_OFFSET
from ..geometry.vtk_objects import of_vtk
from ..tree import Tree
from .readers import pyvista


class FastlinesAccessor:
    """The lines of a mesh, a tree over them, and its queries.

    The lines are those of `fastlines.lines`. Vertices and polygons are not tested. The tree is built on the first
    query, and again if the mesh has changed since (by ``mesh.GetMTime()``).

    Parameters
    ----------
    mesh : pyvista.PolyData

    Examples
    --------
    >>> import pyvista as pv  # doctest: +SKIP
    >>> mesh = pv.read("stroke.trk")  # doctest: +SKIP
    >>> mesh.fastlines.first_hit([0, 0, -200], [0, 0, 1], radius=0.5).t  # doctest: +SKIP
    """

    def __init__(self, mesh: Any) -> None:
        self._mesh = mesh
        self._time = -1
        self._lines: Lines | None = None
        self._tree: Tree | None = None

    def _refresh(self) -> None:
        """Forget the lines and the tree of an earlier state of the mesh."""
        time = self._mesh.GetMTime()
        if time != self._time:
            self._time, self._lines, self._tree = time, None, None

    @property
    def lines(self) -> Lines:
        """The lines of the mesh; `Lines.strands` are the numbers of the line cells."""
        self._refresh()
        if self._lines is None:
            # Do not warn of polygons and other oddities of a mesh: its owner knows them.
            self._lines = of_vtk(self._mesh, Making("error", NO_OFFSET, lambda text: None))
        assert self._lines is not None
        return self._lines

    @property
    def tree(self) -> Tree:
        """The tree over the lines, as `fastlines.build` makes it."""
        self._refresh()
        if self._tree is None:
            self._tree = build(self.lines)
        return self._tree

    def first_hit(self, origins: Any, directions: Any, radius: Any = None, **more: Any) -> Any:
        """Return the nearest hit of each ray; see `Tree.first_hit`."""
        return self.tree.first_hit(origins, directions, radius, **more)

    def all_hits(self, origins: Any, directions: Any, radius: Any = None, **more: Any) -> Any:
        """Return all hits of each ray; see `Tree.all_hits`."""
        return self.tree.all_hits(origins, directions, radius, **more)

    def next_hits(self, origins: Any, directions: Any, radius: Any = None, k: int | None = None, **more: Any) -> Any:
        """Return the first k hits of each ray; see `Tree.next_hits`."""
        return self.tree.next_hits(origins, directions, radius, k, **more)

    def any_hit(self, origins: Any, directions: Any, radius: Any = None, **more: Any) -> Any:
        """Return whether each ray hits anything; see `Tree.any_hit`."""
        return self.tree.any_hit(origins, directions, radius, **more)

    def count_hits(self, origins: Any, directions: Any, radius: Any = None, **more: Any) -> Any:
        """Return the number of hits of each ray; see `Tree.count_hits`."""
        return self.tree.count_hits(origins, directions, radius, **more)


# PyVista imports this module to have the class registered.
with contextlib.suppress(MissingExtraError):
    pyvista().register_dataset_accessor("fastlines", pyvista().PolyData)(FastlinesAccessor)
