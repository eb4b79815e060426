"""Forests: trees over the tiles of a scene that need not fit into memory, which are queried as one tree."""

from __future__ import annotations

import contextlib
import copy
import os
from pathlib import Path
from typing import Any, TypeAlias, cast

from ..arrays import FloatArray, byte_count, choice, count, instance, is_on_device
from ..errors import FileFormatError, InputError
from ..geometry.any_geometry import AnyGeometry
from ..progress import ProgressCallback, ProgressOption, reporting
from ..query.backend import KERNELS, Backend
from ..query.proximity.backend import PointBackend
from ..query.proximity.box_queries import BoxQueries, RowLists
from ..query.proximity.pair_backend import PairBackend, PairsOfSets
from ..query.proximity.pair_queries import PairQueries
from ..query.proximity.pair_sets import PairSets
from ..query.proximity.point_arguments import PointArguments
from ..query.proximity.points import check_points
from ..query.proximity.queries import PointQuery, ProximityQueries
from ..query.proximity.regions import Regions
from ..query.queries import Query, check_query
from ..query.ray_arguments import RayArguments
from ..query.ray_queries import RayQueries
from ..query.rays import RayBatch, require_radius
from ..query.wrappers.ignore import IgnoringBackend
from ..support.computed_once import computed_once
from ..support.texts import bytes_text, counted
from ..tree import Tree
from .box_search import find_in_boxes
from .geometry import ForestGeometry
from .index import Index
from .manifest import ADVICE, Manifest
from .mapping.dask_rays import DaskRays, has_dask_rays
from .mapping.mapped_pairs import MappedPairs
from .mapping.mapped_points import MappedPoints
from .mapping.mapped_rays import MappedRays
from .mapping.mapping import Mapping
from .mapping.where import mapping_of
from .pair_sets import TileSets
from .point_backend import ForestPoints
from .ray_backend import ForestRays
from .tile_files import manifest_of_tree, next_name, write_tile
from .tile_store import TileStore, read_tile
from .top_tree import TopTree


class Forest(RayQueries, ProximityQueries, PairQueries, BoxQueries):
    """Trees over the tiles of a scene, in a folder that `build_forest` makes; or one tree file.

    It has the queries of a `Tree`, and its answers are those of one tree over the whole scene, bit for bit. Ids,
    strands and attributes are those of the whole. A tile is mapped into memory by the first query that needs it.

    Parameters
    ----------
    path : str or path
        The folder of a forest, or a file that `Tree.save` has written.
    memory : int, optional
        How many bytes the open tiles may take. The default is half of the memory that is free.
    verify : bool, optional
        Whether to verify the checksums of a tile when this process first opens it. The default verifies files of up to
        1 GiB; see `load`.

    Attributes
    ----------
    path : Path
    geometry : geometry of the whole
        Hits refer to it. It reads attributes, tangents and points from the tiles.

    Raises
    ------
    FileFormatError
        If the folder is none of a forest, or is half built; or if a file is damaged or of another build. That of a tile
        is noticed when it is opened.
    InputError
        If a tile takes more than `memory`.
    OSError
        If there is no such path, or it cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> import fastlines as fl
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     fl.build([[[-1, -1, -1], [1, 1, 1]]]).save(f"{folder}/line.flt")
    ...     Forest(f"{folder}/line.flt").first_hit([0, 0, -5], [0, 0, 1], 0.5).t
    array(5., dtype=float32)
    """

    geometry: AnyGeometry

    def __init__(self, path: str | os.PathLike[str], *, memory: int | None = None, verify: bool | None = None) -> None:
        if memory is not None:
            memory = byte_count("memory", memory)
        if verify is not None:
            instance("verify", verify, bool, "True, False or None")
        self.path = Path(path)
        self._mapping: Mapping | None = None
        self._less_offset = False
        self._is_file = self.path.is_file()
        if self._is_file:
            self._store = TileStore(self.path.parent, manifest_of_tree(self.path, verify), memory, verify)
            self.geometry = self._store.open(0).tree.geometry
            return
        manifest = Manifest.read(self.path)
        self._store = TileStore(self.path, manifest, memory, verify)
        index = Index.read(self.path, manifest.n_prims, manifest.index, verify)
        self.geometry = ForestGeometry(self._store, index)

    def __reduce__(self) -> tuple[Any, ...]:
        return _opened, (os.fspath(self.path), self._store.memory, self._store.verify, self._less_offset)

    def __repr__(self) -> str:
        return (
            f"<Forest {self.manifest.method}: {counted(self.n_prims, self.geometry.noun)} in "
            f"{counted(self.n_tiles, 'tiles')}, {bytes_text(self._n_bytes)}>"
        )

    @property
    def manifest(self) -> Manifest:
        """What is known of the forest without its tiles."""
        return self._store.manifest

    @property
    def n_prims(self) -> int:
        """The number of primitives."""
        return len(self.geometry)

    @property
    def n_tiles(self) -> int:
        """The number of tiles."""
        return len(self._store)

    @property
    def box(self) -> FloatArray:
        """The box of all axes, (2, 3): its lowest and its highest corner."""
        return self.manifest.bounds

    @property
    def backend(self) -> str:
        """What answers queries: "cpu"."""
        return "cpu"

    def without_offset(self) -> Forest:
        """Return the forest of the same lines without their offset: rays and points are then less it."""
        made = copy.copy(self)
        made.geometry, made._less_offset = self.geometry.without_offset(), True
        return made

    def _here(self) -> Forest:
        """Return this forest, with queries that this process answers."""
        made = copy.copy(self)
        made._mapping = None
        return made

    @property
    def _n_bytes(self) -> int:
        return sum(tile.n_bytes for tile in self.manifest.tiles)

    def stats(self) -> dict[str, Any]:
        """Return counts and sizes, ready for JSON.

        Examples
        --------
        >>> import tempfile
        >>> import fastlines as fl
        >>> segments = [[[x, 0, 0], [x, 1, 0]] for x in range(10)]
        >>> stats = fl.build_forest(segments, tempfile.mkdtemp(), max_segments=5).stats()
        >>> stats["n_prims"], stats["n_tiles"], stats["largest_tile"]
        (10, 3, 4)
        """
        sizes = [tile.n_prims for tile in self.manifest.tiles]
        return {
            "method": self.manifest.method,
            "n_prims": self.n_prims,
            "n_refs": sum(tile.n_refs for tile in self.manifest.tiles),
            "n_strands": self.manifest.n_strands,
            "n_tiles": self.n_tiles,
            "smallest_tile": min(sizes, default=0),
            "largest_tile": max(sizes, default=0),
            "file_bytes": self._n_bytes,
            "frame": self.manifest.frame.tolist(),
            "version": self.manifest.version,
        }

    # --- Queries ---

    def on(self, where: Any, *, n_threads: int | None = None) -> Forest:
        """Return this forest, with queries that other processes answer, which see the same files.

        The answers are the same. Rays and points are sorted by the tiles that they meet, and sent in chunks. Each
        process keeps the tiles open that it has opened. Up to 256 rays or points are answered here.

        Parameters
        ----------
        where : Client of dask.distributed, or callable
            The workers of Dask, or a function that is called as ``where(function, tasks)`` and returns or yields
            ``function(task)`` for each task of a list, in their order: the `map` of an executor, for example.
        n_threads : int, optional
            How many threads each task uses. The default shares those of a worker of Dask among its tasks, and is 1
            elsewhere.

        Returns
        -------
        Forest
            This one stays as it is.

        Raises
        ------
        InputError
            If `where` is neither. Queries raise `WorkerError` if workers cannot answer them: there is no half answer.

        Examples
        --------
        >>> import fastlines as fl
        >>> from concurrent.futures import ThreadPoolExecutor
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder, ThreadPoolExecutor(2) as executor:
        ...     fl.build([[[-1, -1, -1], [1, 1, 1]]]).save(f"{folder}/tree.flt")
        ...     print(fl.Forest(f"{folder}/tree.flt").on(executor.map).first_hit([0, 0, -5], [0, 0, 1], 0.5).t)
        5.0
        """
        made = copy.copy(self)
        made._mapping = mapping_of(where, n_threads)
        return made

    def __copy__(self) -> Forest:
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__)
        return made

    @computed_once
    def _top(self) -> TopTree:
        return TopTree(self.manifest.boxes, self.manifest.max_radius, self.manifest.frame)

    def _query(self, kernel: str, given: RayArguments) -> Query:
        """Check the rays, and choose the backend."""
        choice("kernel", kernel, tuple(KERNELS))
        if is_on_device(given.origins):
            raise InputError("rays are in the memory of a GPU, and forests run on the CPU; pass NumPy arrays")
        if has_dask_rays(given):
            require_radius(self.geometry, given.radius, given.spread)
            backend = MappedRays(self, kernel, self._mapping or Mapping(map))
            return Query(backend, DaskRays.of(self, kernel, given), self.geometry)
        rays = check_query(self.geometry, self.manifest.frame, given)
        mapped = None if self._mapping is None else MappedRays(self, kernel, self._mapping)
        return Query(mapped or self._backend(kernel, rays), rays, self.geometry, given.progress)

    def _backend(self, kernel: str, rays: RayBatch) -> Backend:
        """Return what answers checked rays."""
        if self._is_file:
            return self._store.open(0).tree._backend(kernel, rays)
        backend: Backend = ForestRays(self._store, self._top, kernel)
        return IgnoringBackend(backend, self.geometry) if rays.ignored else backend

    def _point_query(self, given: PointArguments) -> PointQuery:
        """Check the points, and choose the backend."""
        points, backend = check_points(self.geometry, self.manifest.frame, given), self._point_backend()
        if self._mapping is not None:
            backend = MappedPoints(self, backend, self._mapping)
        return PointQuery(backend, points, self.geometry, given.progress)

    def _point_backend(self) -> PointBackend:
        """Return what answers checked points."""
        if self._is_file:
            return self._store.open(0).tree._point_backend()
        return ForestPoints(self._store, self._top)

    def _find_in_boxes(self, regions: Regions, n_threads: int, progress: ProgressCallback | None) -> RowLists:
        """List what is in checked boxes."""
        if self._is_file:
            return self._store.open(0).tree._find_in_boxes(regions, n_threads, progress)
        return find_in_boxes(self._store, self._top, regions, n_threads, progress)

    def _pair_sets(self) -> PairSets:
        """Return what pairs are sought in."""
        if self._is_file:
            return self._store.open(0).tree._pair_sets()
        return TileSets(self._store, self._top, cast(ForestGeometry, self.geometry))

    def _pair_backend(self, other: PairQueries | None) -> PairBackend:
        """Return what finds pairs; those with a tree in memory are found here."""
        here = PairsOfSets(self._pair_sets(), None if other is None else other._pair_sets())
        if self._mapping is None or not (other is None or isinstance(other, Forest)):
            return here
        return MappedPairs(self, other, here, self._mapping)

    # --- Files ---

    def verify(self, *, progress: ProgressOption = False) -> None:
        """Verify the checksums of all files, and check that each tree can be used, whatever was verified before.

        Raises
        ------
        FileFormatError
            If a file is missing, damaged or of another build; the error names each.
        """
        faults = []
        with reporting(progress, "verify") as callback:
            for number in range(-1, self.n_tiles):
                try:
                    self._verify(number)
                except FileFormatError as error:
                    faults.append(str(error))
                if callback is not None:
                    callback((number + 2) / (self.n_tiles + 1))
        if faults:
            raise FileFormatError("\n".join(faults))

    def _verify(self, number: int) -> None:
        """Verify the file of a tile, or with -1 that of the index."""
        if number < 0:
            if not self._is_file:
                Index.read(self.path, self.n_prims, self.manifest.index, True)
            return
        tile = read_tile(self._store.folder, number, self.manifest.tiles[number], True)
        if isinstance(self.geometry, ForestGeometry) and not self.geometry.index.holds(number, tile.ids):
            raise FileFormatError(
                f"{self.path / self.manifest.tiles[number].file} does not hold the primitives that the index says; "
                f"{ADVICE}"
            )

    def rebuild(self, tile: int, method: str | None = None, **settings: Any) -> Forest:
        """Build the tree of a tile again, with other settings, and return the forest with it.

        The answers are the same. The new file stands beside the old one until the manifest names it, so nothing is lost
        if the process ends. Other forests of this folder that are open keep the tiles that they have open.

        Parameters
        ----------
        tile : int
            Tiles count from 0.
        method, **settings
            As `build` takes them, but for `own_radius` and `frame`.

        Examples
        --------
        >>> import tempfile
        >>> import fastlines as fl
        >>> segments = [[[x, 0, 0], [x, 1, 0]] for x in range(10)]
        >>> forest = fl.build_forest(segments, tempfile.mkdtemp(), max_segments=5)
        >>> forest.rebuild(2, "bvh-ss").first_hit([7, 0.5, -1], [0, 0, 1], 0.1).prim
        array(7)
        """
        if self._is_file:
            raise InputError(f"{self.path} is the file of one tree; build the tree again with fl.build, and save it")
        for name in ("own_radius", "frame"):
            if name in settings:
                raise InputError(
                    f"{name} is the same in all tiles of a forest; leave it out, or build the forest again"
                )
        number = count("tile", tile, 0, self.n_tiles - 1)
        if Manifest.read(self.path).digest != self.manifest.digest:
            raise InputError(f"{self.path} has changed since this forest was opened; open it again")
        old, opened = self.manifest.tiles[number], self._store.open(number)
        assert opened.ids is not None
        facts = write_tile(
            self.path,
            number,
            opened.tree.geometry,
            opened.ids,
            opened.places,
            self.manifest.frame,
            method,
            file=next_name(old.file),
            **settings,
        )
        self.manifest.with_tile(number, facts).write(self.path)
        with contextlib.suppress(OSError):  # where it is mapped, it may have to stay
            (self.path / old.file).unlink()
        return Forest(self.path, memory=self._store.memory, verify=self._store.verify)


#: What answers queries: one tree, or a forest.
AnyTree: TypeAlias = Tree | Forest


def _opened(path: str, memory: int | None, verify: bool | None, less_offset: bool) -> Forest:
    forest = Forest(path, memory=memory, verify=verify)
    return forest.without_offset() if less_offset else forest
