"""The acceleration tree: queries, refits and files."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy.typing as npt

from . import _core
from .arrays import FloatArray, choice, is_on_device
from .cuda.device_rays import check_device_query
from .cuda.placed_tree import PlacedTree
from .engines import engine
from .errors import InputError
from .geometry.lines import Lines
from .progress import ProgressCallback, ProgressOption
from .query.backend import KERNELS, Backend, CompiledBackend
from .query.proximity.backend import PointBackend
from .query.proximity.box_queries import BoxQueries, RowLists
from .query.proximity.pair_queries import PairQueries
from .query.proximity.pair_sets import PairSets, TreeSet
from .query.proximity.point_arguments import PointArguments
from .query.proximity.points import check_points
from .query.proximity.queries import PointQuery, ProximityQueries, point_backend
from .query.proximity.regions import Regions
from .query.proximity.strand_places import Int32Array, strand_places
from .query.queries import Query, check_query
from .query.ray_arguments import RayArguments
from .query.ray_queries import RayQueries
from .query.rays import RayBatch
from .query.wrappers.pieces import View
from .query.wrappers.wrap import backend_of
from .refit import built_cost, refitted
from .support.computed_once import computed_once


@dataclass(frozen=True, eq=False, repr=False)
class Tree(PlacedTree, RayQueries, ProximityQueries, PairQueries, BoxQueries):
    """An acceleration tree over primitives, as `build` makes it.

    It is immutable. ``nodes`` and ``refs`` are its data; ``cost()``, ``stats()``, ``levels()`` and ``validate()``
    describe it. The queries about rays are ``first_hit``, ``first_surface``, ``any_hit``, ``count_hits``, ``all_hits``,
    ``iter_all_hits`` and ``next_hits``, each with its own radius; those about points are ``nearest``, ``within`` and
    ``count_within``. ``pairs`` finds what is near to each other, ``along`` what is near to a polyline, and ``in_box``
    what is in boxes.
    """

    @computed_once
    def _binary_view(self) -> _core.BinaryView:
        return self._binary_over(*self.geometry.core_data())

    def _binary_view_of_parts(self, parts: tuple[int, ...] | None) -> _core.BinaryView:
        return self._binary_view if parts is None else self._binary_over(*self.geometry.seen_data(parts))

    @computed_once
    def _spread_binary_view(self) -> _core.BinaryView:
        return self._binary_over(*self.geometry.spread_data())

    def _binary_over(self, kind: str, data: FloatArray) -> _core.BinaryView:
        if self.settings.boxes == "cut":
            return _core.BinaryView.of_planes(kind, data, *self.planes)
        return _core.BinaryView.of_boxes(kind, data, *self.words(), self.frame_box.reshape(-1).tolist())

    def _query(self, kernel: str, given: RayArguments) -> Query:
        """Check the rays, and choose the backend."""
        choice("kernel", kernel, tuple(KERNELS))
        if is_on_device(given.origins):
            gpu = self._on_gpu(given.has_spread, alone=True)
            return Query(gpu, check_device_query(gpu, self.geometry, self.frame_box, given), self.geometry)
        rays = check_query(self.geometry, self.frame_box, given)
        return Query(self._backend(kernel, rays), rays, self.geometry, given.progress)

    def _backend(self, kernel: str, rays: RayBatch) -> Backend:
        """Return what answers checked rays."""
        if self.backend == "cuda" and kernel != "auto":
            raise InputError(f"kernel={kernel!r} is one of the CPU's; leave it out, or query the tree on the CPU")
        core: Backend
        view: View
        if kernel == "binary":
            view = self._spread_binary_view if rays.has_spread else self._binary_view_of_parts(rays.parts)
            core = CompiledBackend(_core, view)
        else:
            view = self.layout.spread_view if rays.has_spread else self.layout.view_of_parts(rays.parts)
            core = CompiledBackend(engine, view, (KERNELS[kernel],))
        if self.backend == "cuda":
            core = self._on_gpu(rays.has_spread, rays.parts)
        return backend_of(self.geometry, core, view, rays)

    def _point_query(self, given: PointArguments) -> PointQuery:
        points = check_points(self.geometry, self.frame_box, given)
        return PointQuery(self._point_backend(), points, self.geometry, given.progress)

    def _point_backend(self) -> PointBackend:
        """Return what answers points."""
        return point_backend(self.geometry, engine, self.layout.view)

    def _find_in_boxes(self, regions: Regions, n_threads: int, progress: ProgressCallback | None) -> RowLists:
        return engine.in_box(self.layout.view, regions.low, regions.high, regions.surface, n_threads, progress)

    @computed_once
    def _strand_places(self) -> Int32Array | None:
        return strand_places(self.geometry)

    def _pair_sets(self) -> PairSets:
        return TreeSet(self.geometry, lambda: self.layout.view, lambda: self._strand_places)

    def without_offset(self) -> Tree:
        """Return the tree over the same lines without their offset: rays and points are then less it."""
        geometry = self.geometry.without_offset()
        if geometry is self.geometry:
            return self
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__)
        made.__dict__["geometry"] = geometry
        return made

    def refit(self, lines: Lines | npt.ArrayLike, *, progress: ProgressOption = False) -> Tree:
        """Make the same tree over segments that have moved: same nodes and pieces, boxes fitted anew.

        A refit is much faster than a build, and answers are exact, but boxes overlap more as neighbours move apart.
        `growth` is the factor by which the cost has grown; `RebuildPolicy` decides when to rebuild. A `layout` is
        refitted too.

        Parameters
        ----------
        lines : Lines or (n, 2, 3) array
            As many segments as the tree has, in the same order. With an array, the tree's strands, radii and
            attributes are kept. A writeable array is copied.
        progress : bool or callable
            Show a bar, or call back with the fraction that is done.

        Returns
        -------
        Tree
            A BVH, also from a KD tree: after lines have moved, boxes no longer divide space.

        Raises
        ------
        InputError
            If there are more or fewer segments, one holds NaN or Inf, or they leave the frame of the build.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
        >>> tree.refit([[[-1, -1, 0], [1, 1, 2]]]).first_hit([0, 0, -5], [0, 0, 1], 0.5).t
        array(6., dtype=float32)
        """
        return refitted(self, self.geometry.moved(lines), self._built_cost, progress)

    @computed_once
    def _built_cost(self) -> float:
        return built_cost(self)

    def save(self, path: str | os.PathLike[str], *, layout: bool = False) -> None:
        """Write the tree and its lines to one file, which `load` maps into memory.

        Attributes that are neither booleans nor numbers of up to 8 bytes are left out, with a warning. The file appears
        whole or not at all. A symbolic link stays one, and an existing file keeps its mode.

        Parameters
        ----------
        path : str or path
        layout : bool
            Write the `layout` that queries run on, too. Then the first query after a `load` starts at once; without, it
            builds the layout first. `fastlines.load` checks it.

        Raises
        ------
        InputError
            If the tree is over a class of your own, or the path is a device, a pipe or a socket, or has the extension
            of lines.
        OSError
            If the path is a folder, or cannot be written.
        """
        from .structure import tree_file

        tree_file.write(self, path, layout=layout)


def load(path: str | os.PathLike[str], *, verify: bool | None = None) -> Tree:
    """Map a saved tree into memory and check that it can be used.

    The checks are those of every tree (`Tree`), so no hit is lost or reported twice; `Tree.validate` checks the axioms
    too. The tree reads the file while it is used, so replace a file as a whole and never edit it in place.

    Parameters
    ----------
    path : str or path
    verify : bool, optional
        Whether to verify the checksums, which detect damage that leaves a tree usable, such as another coordinate. The
        default verifies files of up to 1 GiB.

    Raises
    ------
    FileFormatError
        If the file is not a whole, usable tree, or its checksums differ.
    OSError
        If it cannot be read.
    """
    from .structure import tree_file

    return tree_file.read(Tree, path, verify)
