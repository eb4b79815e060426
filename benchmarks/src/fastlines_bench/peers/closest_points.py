"""Peers that find the point of a scene that is nearest to a point: libigl, fcpw, and k-d trees over samples of lines.

- libigl, a tree of boxes that is kept (``igl.AABB``), takes segments as edges.
- fcpw, a wide tree of boxes in float32, takes triangles; a segment is one with two equal corners. It gets the points in
  Morton order, which is not timed. Segments without a length are left out: some of its distances to them are infinite.
- The k-d trees of scipy and of pykdtree hold samples, so close that no distance is wrong by more than `SAMPLING`.

Source: Jacobson et al., libigl; Sawhney, "FCPW: fastest closest points in the west", 2021.
"""

from __future__ import annotations

import importlib
import importlib.util
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from fastlines import InputError, Lines

from ..harness.arrays import Float64Array, IntArray

#: The largest error of a distance to the nearest sample, as a fraction of the length of the diagonal of the box.
SAMPLING = 1e-3

#: The number of distances of fcpw that are compared: each is read by itself.
N_READ = 1 << 11


@dataclass(frozen=True)
class Search:
    """A search for the points nearest to given ones.

    Attributes
    ----------
    run : callable
        Searches, and returns the answer in the peer's own form.
    distances : callable
        Returns of such an answer the indices of some or all points, and their distances.
    """

    run: Callable[[], Any]
    distances: Callable[[Any], tuple[IntArray, Float64Array]]


class ClosestPoints(ABC):
    """A peer's tree over lines.

    Parameters
    ----------
    lines : Lines
    n_threads : int

    Attributes
    ----------
    n_items : int
        The number of segments or samples in the tree.
    build_s : float
        The seconds of the clock that its build takes, samples excluded.
    """

    #: The name on the command line, the package that is imported, and the distribution that has it.
    name: ClassVar[str]
    module: ClassVar[str]
    #: Whether distances are those of segments; those of samples may be larger by `SAMPLING`.
    exact: ClassVar[bool]
    n_items: int
    build_s: float

    @abstractmethod
    def __init__(self, lines: Lines, n_threads: int) -> None: ...

    @abstractmethod
    def search(self, points: Float64Array, k: int) -> Search | None:
        """Return a search for the k nearest items of each point; None if the peer finds one only."""


class Libigl(ClosestPoints):
    """The kept tree of libigl."""

    name, module, exact = "libigl", "igl", True

    def __init__(self, lines: Lines, n_threads: int) -> None:
        self._vertices, self._edges = _mesh(lines.segments)
        self.n_items = len(self._edges)
        self._tree = importlib.import_module(self.module).AABB()
        start = perf_counter()
        self._tree.init(self._vertices, self._edges)
        self.build_s = perf_counter() - start

    def search(self, points: Float64Array, k: int) -> Search | None:
        """Return a search for the nearest segment."""
        if k > 1:
            return None

        def run() -> Any:
            return self._tree.squared_distance(self._vertices, self._edges, points)

        return Search(run, lambda answer: (np.arange(len(points)), np.sqrt(answer[0])))


class Fcpw(ClosestPoints):
    """The trees of fcpw: that for vectors and that for scalars, of which the faster one is timed."""

    name, module, exact = "fcpw", "fcpw", True

    def __init__(self, lines: Lines, n_threads: int) -> None:
        self._fcpw = importlib.import_module(self.module)
        segments = lines.segments[(lines.segments[:, 0] != lines.segments[:, 1]).any(axis=1)]
        vertices, edges = _mesh(segments)
        self.n_items = len(edges)
        self._scenes = []
        for is_vectorized in (True, False):
            scene = self._fcpw.scene_3D()
            scene.set_object_count(1)
            scene.set_object_vertices(np.asfortranarray(vertices, np.float32), 0)
            scene.set_object_triangles(np.asfortranarray(edges[:, [0, 1, 1]], np.int32), 0)
            start = perf_counter()
            scene.build(self._fcpw.aggregate_type.bvh_surface_area, is_vectorized)
            self.build_s = perf_counter() - start
            self._scenes.append(scene)

    def search(self, points: Float64Array, k: int) -> Search | None:
        """Return a search for the nearest segment, by the tree that is faster for some of the points."""
        if k > 1:
            return None
        order = morton_order(points)
        everything = np.asfortranarray(points[order], np.float32)
        few = everything[: len(points) // 8 + 1]

        def run_in(scene: Any, of: Any) -> Any:
            found = self._fcpw.interaction_3D_list()
            scene.find_closest_points(np.asfortranarray(of), np.full(len(of), np.inf, np.float32), found)
            return found

        def seconds(scene: Any) -> float:
            start = perf_counter()
            run_in(scene, few)
            return perf_counter() - start

        fastest = min(self._scenes, key=seconds)
        step = len(points) // N_READ + 1

        def distances(answer: Any) -> tuple[IntArray, Float64Array]:
            places = range(0, len(points), step)
            return order[::step], np.array([answer[i].d for i in places], np.float64)

        return Search(lambda: run_in(fastest, everything), distances)


class _Samples(ClosestPoints):
    """A k-d tree over samples of the lines."""

    exact = False

    def __init__(self, lines: Lines, n_threads: int) -> None:
        low, high = lines.bounds.astype(np.float64)
        # A sample is at most half a spacing away from the nearest point.
        samples, _ = sample(lines, 2 * SAMPLING * float(np.sqrt(((high - low) ** 2).sum())))
        self.n_items = len(samples)
        self._n_threads = n_threads
        start = perf_counter()
        self._tree = self._build(samples)
        self.build_s = perf_counter() - start

    @abstractmethod
    def _build(self, samples: Float64Array) -> Any: ...

    @abstractmethod
    def _query(self, points: Float64Array, k: int) -> Any: ...

    def search(self, points: Float64Array, k: int) -> Search | None:
        """Return a search for the k nearest samples, several of which may be of one segment."""

        def distances(answer: Any) -> tuple[IntArray, Float64Array]:
            found = answer[0] if k == 1 else answer[0][:, 0]
            return np.arange(len(points)), np.asarray(found, np.float64)

        return Search(lambda: self._query(points, k), distances)


class Scipy(_Samples):
    """The k-d tree of scipy."""

    name, module = "scipy", "scipy.spatial"

    def _build(self, samples: Float64Array) -> Any:
        return importlib.import_module(self.module).cKDTree(samples)

    def _query(self, points: Float64Array, k: int) -> Any:
        return self._tree.query(points, k=k, workers=self._n_threads)


class Pykdtree(_Samples):
    """The k-d tree of pykdtree."""

    name, module = "pykdtree", "pykdtree.kdtree"

    def _build(self, samples: Float64Array) -> Any:
        return importlib.import_module(self.module).KDTree(samples)

    def _query(self, points: Float64Array, k: int) -> Any:
        return self._tree.query(points, k=k)


PEERS: dict[str, type[ClosestPoints]] = {peer.name: peer for peer in (Libigl, Fcpw, Scipy, Pykdtree)}


def is_installed(name: str) -> bool:
    """Return whether the package of a peer is installed."""
    return importlib.util.find_spec(PEERS[name].module.partition(".")[0]) is not None


def check_installed(name: str) -> None:
    """Raise an error if the package of a peer is not installed."""
    if not is_installed(name):
        raise InputError(f"{name} is not installed: run  pip install './benchmarks[nearest]'")


def sample(lines: Lines, spacing: float) -> tuple[Float64Array, IntArray]:
    """Return the middles of pieces of all segments, which are at most `spacing` long; and the segment of each."""
    ends = lines.segments.astype(np.float64)
    edges = ends[:, 1] - ends[:, 0]
    counts = np.maximum(1, np.ceil(np.sqrt((edges**2).sum(axis=1)) / spacing)).astype(np.int64)
    of = np.repeat(np.arange(len(ends)), counts)
    number = np.arange(len(of)) - (np.cumsum(counts) - counts)[of]
    return ends[of, 0] + ((number + 0.5) / counts[of])[:, None] * edges[of], of


def morton_order(points: Float64Array) -> IntArray:
    """Return the order of points along a Morton curve through 1,024 cells a side."""
    low, high = points.min(axis=0), points.max(axis=0)
    cells = ((points - low) / ((high - low).max() or 1.0) * 1023).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= (cells[:, axis] >> bit & 1) << 3 * bit + axis
    return np.argsort(code, kind="stable")


def _mesh(segments: Any) -> tuple[Float64Array, IntArray]:
    """Return segments as (2 n, 3) vertices and (n, 2) edges."""
    n = len(segments)
    vertices = np.asarray(segments, np.float64).transpose(1, 0, 2).reshape(-1, 3)
    return np.ascontiguousarray(vertices), np.stack([np.arange(n), np.arange(n) + n], axis=1)
