"""The speed of the nearest segments of points beside peers, and of `within` beside rays without a length."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from fastlines import Tree, build

from ..harness import machine
from ..harness.arrays import Float64Array
from ..harness.clock import clock, median_ratio, take_turns
from ..harness.findings import Check
from ..harness.internals import num_threads
from ..harness.preset import TimedPreset, sized
from ..peers.closest_points import PEERS, SAMPLING, ClosestPoints
from .scenes import PointScene, points_of_users

#: The peers' times divided by ours that are wanted at least, by scene and peer, for one nearest segment.
FLOORS: dict[str, dict[str, float]] = {
    "neuron": {"libigl": 2, "fcpw": 1.1, "scipy": 4, "pykdtree": 2.5},
    "bun-hair": {"libigl": 10, "fcpw": 2, "scipy": 6, "pykdtree": 5},
    "straight-hair": {"libigl": 10, "fcpw": 2, "scipy": 6, "pykdtree": 5},
    "tracts": {"libigl": 8, "fcpw": 2, "scipy": 4, "pykdtree": 4},
    "spaghetti": {"libigl": 60, "fcpw": 35, "scipy": 4, "pykdtree": 5},
}

#: The ratios of rays to `within` that are wanted at least, by radius.
WITHIN_FLOORS = {"dense": 1.3, "sparse": 1.0}

#: Distances agree if they differ by at most this fraction of the size.
TOLERANCE = 1e-5

#: A dense radius has at most so many segments within it in the mean, and a sparse one has any for this fraction of the
#: points.
N_DENSE, SPARSE = 32, 0.25

#: The number of points by which the radii are set.
N_TRIED = 1 << 12


@dataclass(frozen=True, kw_only=True)
class NearestPreset(TimedPreset):
    """How much to measure.

    Parameters
    ----------
    n_points : int
        The number of points.
    peers : tuple of str
        Keys of `PEERS`.
    floors : bool
        Whether ratios are compared with those that are wanted, which are for scenes of full size.
    counts : tuple of int
        The numbers of segments to find, k.
    """

    n_points: int = sized(1 << 16, 1 << 12)
    rounds: int = sized(5, 3)
    peers: tuple[str, ...] = tuple(PEERS)
    floors: bool = sized(True, False)
    counts: tuple[int, ...] = (1, 8)


@dataclass(frozen=True)
class Rival:
    """A peer on the points of a cell.

    Attributes
    ----------
    n_items : int
        The number of segments or samples in its tree.
    build_s : float
        The seconds of the build of its tree.
    mpoints : float
        Millions of points per second; the median.
    ratio : float
        The median, over rounds, of its time divided by ours.
    least, most : float
        The extremes of its distances less ours, as fractions of the size.
    floor : float or None
        The ratio that is wanted.
    """

    peer: str
    n_items: int
    build_s: float
    mpoints: float
    ratio: float
    least: float
    most: float
    floor: float | None


@dataclass(frozen=True)
class NearestCell:
    """The k nearest segments of points of a scene; `mpoints` are ours."""

    scene: str
    source: str
    n_prims: int
    n_points: int
    k: int
    build_s: float
    mpoints: float
    rivals: tuple[Rival, ...]


@dataclass(frozen=True)
class WithinCell:
    """All segments within a radius of points, and the hits of rays from t = 0 to t = 0 with that radius.

    Attributes
    ----------
    name : str
        A key of `WITHIN_FLOORS`.
    per_point : float
        The mean number of segments within the radius.
    within_ns, count_ns, ray_ns : float
        Nanoseconds a point of `within`, `count_within` and `all_hits`; medians.
    ratio : float
        The median, over rounds, of the rays' time divided by that of `within`.
    differ : float
        The fraction of the segments that one of both alone reports: rays round the point to float32 first.
    """

    scene: str
    name: str
    radius: float
    n_points: int
    per_point: float
    within_ns: float
    count_ns: float
    ray_ns: float
    ratio: float
    differ: float


@dataclass(frozen=True)
class NearestResult:
    """All cells; `missing` are the peers that are not installed."""

    machine: dict[str, Any]
    preset: NearestPreset
    missing: tuple[str, ...]
    nearest: list[NearestCell]
    within: list[WithinCell]
    seconds: float

    def checks(self) -> list[Check]:
        """Return the ratios that are wanted, as checks."""
        if not self.preset.floors:
            return []
        found = [
            Check(f"nearest: ratio to {rival.peer}", rival.ratio, least=rival.floor, scene=cell.scene)
            for cell in self.nearest
            for rival in cell.rivals
            if rival.floor is not None
        ]
        return found + [
            Check(f"within, {cell.name}: ratio to rays", cell.ratio, least=WITHIN_FLOORS[cell.name], scene=cell.scene)
            for cell in self.within
        ]

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        checks = [check.to_json() for check in self.checks()]
        return {"format": "fastlines-bench nearest 1", **asdict(self), "checks": checks}


def run_nearest(
    scenes: list[PointScene],
    preset: NearestPreset,
    missing: tuple[str, ...] = (),
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> NearestResult:
    """Time all sides in turn on the points of each scene; the answers must agree.

    Parameters
    ----------
    scenes : list of PointScene
    preset : NearestPreset
    missing : tuple of str
        Peers that are not installed, for the result.
    progress : callable
        Called with the current work and the share of all work that is done.

    Raises
    ------
    RuntimeError
        If a distance of a peer differs from ours by more than it should.
    """
    start = time.perf_counter()
    nearest: list[NearestCell] = []
    within: list[WithinCell] = []
    with num_threads(preset.n_threads), machine.few_processors(preset.n_threads):
        where = machine.describe(threads=preset.n_threads)
        for i, scene in enumerate(scenes):
            say = partial(_say, progress, scene.name, i / len(scenes))
            say("building")
            tree, seconds = _built(scene)
            points = points_of_users(scene, preset.n_points)
            peers = [PEERS[name](scene.lines, preset.n_threads) for name in preset.peers]
            for k in preset.counts:
                say(f"nearest, k = {k}")
                nearest.append(_nearest(scene, tree, seconds, peers, points, k, preset))
            say("within")
            within.extend(_within(scene, tree, points, preset))
    return NearestResult(where, preset, missing, nearest, within, time.perf_counter() - start)


def _say(progress: Callable[[str, float], None], where: str, share: float, what: str) -> None:
    progress(f"{where}: {what}", share)


def _built(scene: PointScene) -> tuple[Tree, float]:
    """Build our tree and its layout; return it, and the seconds."""
    start = time.perf_counter()
    tree = build(scene.lines)
    tree.layout  # noqa: B018
    return tree, time.perf_counter() - start


def _nearest(
    scene: PointScene,
    tree: Tree,
    build_s: float,
    peers: list[ClosestPoints],
    points: Float64Array,
    k: int,
    preset: NearestPreset,
) -> NearestCell:
    searches = {peer: search for peer in peers if (search := peer.search(points, k)) is not None}
    sides: dict[str, Callable[[], Any]] = {"ours": lambda: tree.nearest(points, k, to="axis")}
    sides |= {peer.name: search.run for peer, search in searches.items()}
    seconds, answers = take_turns(preset.rounds, sides, clock(preset.n_threads))
    ours = answers["ours"].distance.reshape(len(points), -1)[:, 0].astype(np.float64)

    def mpoints(name: str) -> float:
        return len(points) / statistics.median(seconds[name]) / 1e6

    rivals = []
    for peer, search in searches.items():
        of, distances = search.distances(answers[peer.name])
        off = (distances - ours[of]) / scene.size
        if not (off.min() >= -TOLERANCE and off.max() <= TOLERANCE + (0 if peer.exact else SAMPLING)):
            raise RuntimeError(
                f"{scene.name}: distances of {peer.name} less ours are {off.min():.2g} to {off.max():.2g} of the size"
            )
        ratio = median_ratio(seconds[peer.name], seconds["ours"])
        floor = FLOORS.get(scene.name, {}).get(peer.name) if k == 1 and preset.floors else None
        figures = mpoints(peer.name), ratio, float(off.min()), float(off.max()), floor
        rivals.append(Rival(peer.name, peer.n_items, peer.build_s, *figures))
    own = len(scene.lines), len(points), k, build_s, mpoints("ours")
    return NearestCell(scene.name, scene.source, *own, tuple(rivals))


def _within(scene: PointScene, tree: Tree, points: Float64Array, preset: NearestPreset) -> Iterator[WithinCell]:
    few = points[:N_TRIED]
    distances = tree.nearest(few, min(N_DENSE, len(scene.lines)), to="axis").distance.reshape(len(few), -1)
    low, dense = 0.0, float(np.median(distances[:, -1]))
    for _ in range(10):
        middle = (low + dense) / 2
        if tree.count_within(few, middle, to="axis").mean() < N_DENSE:
            low = middle
        else:
            dense = middle
    radii = {"dense": dense, "sparse": float(np.quantile(distances[:, 0], SPARSE))}
    rounded, direction = points.astype(np.float32), np.array([0, 0, 1], np.float32)
    for name, radius in radii.items():
        sides: dict[str, Callable[[], Any]] = {
            "within": partial(tree.within, points, radius, to="axis"),
            "count": partial(tree.count_within, points, radius, to="axis"),
            "rays": partial(tree.all_hits, rounded, direction, radius, t_min=0.0, t_max=0.0),
        }
        seconds, answers = take_turns(preset.rounds, sides, clock(preset.n_threads))
        found, hits = answers["within"], answers["rays"]
        if not np.array_equal(answers["count"], np.diff(found.offsets)):
            raise RuntimeError(f"{scene.name}: count_within and within differ at the radius {radius:g}")
        mine, theirs = found.point << 32 | found.prim, hits.ray << 32 | hits.prim
        differ = len(np.setxor1d(mine, theirs)) / max(1, len(mine))
        if differ > 0.01:
            raise RuntimeError(f"{scene.name}: {differ:.2%} of the segments within {radius:g} are not hit by rays")
        ns = {side: statistics.median(took) / len(points) * 1e9 for side, took in seconds.items()}
        ratio = median_ratio(seconds["rays"], seconds["within"])
        size = len(points), len(mine) / len(points)
        yield WithinCell(scene.name, name, radius, *size, ns["within"], ns["count"], ns["rays"], ratio, differ)
