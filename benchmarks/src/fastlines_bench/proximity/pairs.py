"""The speed of all pairs of segments that touch, beside a k-d tree over samples and loops over all pairs."""

from __future__ import annotations

import importlib.util
import math
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from fastlines import FastlinesError, build

from ..harness import machine
from ..harness.arrays import IntArray
from ..harness.clock import clock, median_ratio, take_turns, timed
from ..harness.findings import Check
from ..harness.internals import num_threads
from ..harness.preset import TimedPreset, sized
from ..peers.pairs import AllPairs, SampledPairs, TextbookPairs, load_textbook, segment_distances
from .contacts import GENERATORS, ContactScene

#: The sides beside ours.
PEERS = ("scipy", "all pairs", "textbook")

#: The peers' times divided by ours that are wanted at least, by number of segments and peer.
FLOORS = {(100_000, "scipy"): 20.0, (10_000, "all pairs"): 25.0}

#: The largest time of ours that is wanted for lines that all cross, as a multiple of that of all pairs.
MOST_CROSSING = 1.5

#: The largest exponent that is wanted of our time as a power of the number of segments.
MOST_EXPONENT = 1.15

#: The number of segments of the trial that sets the spacing of samples. The longest segment is halved until so many
#: spacings in a row are slower than the best one.
N_TRIED, N_SLOWER = 10_000, 3

#: Pairs may differ if their distance differs from the radius by at most this fraction of the size.
TOLERANCE = 1e-5


@dataclass(frozen=True, kw_only=True)
class PairsPreset(TimedPreset):
    """How much to measure.

    Parameters
    ----------
    scenes : tuple of str
        Keys of `GENERATORS`.
    sizes : tuple of int
        The numbers of segments of yarn and rods.
    n_crossing : int
        The number of long lines that cross.
    most_scipy, most_all_pairs : int
        The largest scenes that the peers get.
    floors : bool
        Whether figures are compared with those that are wanted, which are for scenes of full size.
    """

    rounds: int = sized(5, 3)
    scenes: tuple[str, ...] = tuple(GENERATORS)
    sizes: tuple[int, ...] = sized((10_000, 100_000, 1_000_000), (1_000, 10_000))
    n_crossing: int = sized(2_000, 500)
    most_scipy: int = 100_000
    most_all_pairs: int = 20_000
    floors: bool = sized(True, False)


@dataclass(frozen=True)
class PairsRival:
    """A peer on a scene.

    Attributes
    ----------
    note : str
        The best spacing of the samples.
    build_s : float
        The seconds of the clock for samples and their tree; 0 without one.
    seconds : float
        The median seconds for the pairs.
    ratio : float
        The median, over rounds, of its time divided by ours.
    n_differ : int
        The pairs that one side alone has; all have a distance equal to the radius up to rounding. All pairs have none.
    """

    peer: str
    note: str
    build_s: float
    seconds: float
    ratio: float
    n_differ: int


@dataclass(frozen=True)
class PairsCell:
    """A scene of one size; `build_s` is for our tree with its layout, `seconds` are the median for the pairs."""

    scene: str
    n_segments: int
    radius: float
    n_pairs: int
    build_s: float
    seconds: float
    rivals: tuple[PairsRival, ...]


@dataclass(frozen=True)
class PairsResult:
    """All cells, and the peers that are missing, each with why."""

    machine: dict[str, Any]
    preset: PairsPreset
    missing: dict[str, str]
    cells: list[PairsCell]
    total_s: float

    def exponent(self, scene: str) -> float | None:
        """Return the exponent of our time, from the smallest to the largest size; None for one size."""
        cells = sorted((cell for cell in self.cells if cell.scene == scene), key=lambda cell: cell.n_segments)
        if len(cells) < 2:
            return None
        first, last = cells[0], cells[-1]
        return math.log(last.seconds / first.seconds) / math.log(last.n_segments / first.n_segments)

    def checks(self) -> list[Check]:
        """Return what is wanted, as checks."""
        if not self.preset.floors:
            return []
        found = []
        for cell in self.cells:
            for rival in cell.rivals:
                what = f"{cell.n_segments:,} segments: ratio to {rival.peer}"
                if cell.scene == "crossing" and rival.peer == "all pairs":
                    what = f"{cell.n_segments:,} segments: our time as a multiple of that of all pairs"
                    found.append(Check(what, 1 / rival.ratio, MOST_CROSSING, scene=cell.scene))
                elif cell.scene != "crossing" and (cell.n_segments, rival.peer) in FLOORS:
                    floor = FLOORS[cell.n_segments, rival.peer]
                    found.append(Check(what, rival.ratio, least=floor, scene=cell.scene))
        for scene in dict.fromkeys(cell.scene for cell in self.cells if cell.scene != "crossing"):
            found.append(Check("exponent of our time", self.exponent(scene), MOST_EXPONENT, scene=scene))
        return found

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        checks = [check.to_json() for check in self.checks()]
        return {"format": "fastlines-bench pairs 1", **asdict(self), "checks": checks}


def run_pairs(preset: PairsPreset, progress: Callable[[str, float], None] = lambda what, share: None) -> PairsResult:
    """Time all sides in turn on each scene; the pairs must be the same.

    Raises
    ------
    RuntimeError
        If a pair differs whose distance is not that of the radius up to rounding.
    """
    start = time.perf_counter()
    missing = _missing(preset)
    plan = [(name, n) for name in preset.scenes for n in _sizes(name, preset)]
    cells, spacings = [], {}
    with num_threads(preset.n_threads), machine.few_processors(preset.n_threads):
        where = machine.describe(threads=preset.n_threads)
        for i, (name, n) in enumerate(plan):
            progress(f"{name}: {n:,} segments", i / len(plan))
            if "scipy" not in missing and n <= preset.most_scipy and name not in spacings:
                spacings[name] = _best_spacing(GENERATORS[name](min(n, N_TRIED)), preset)
            cells.append(_cell(GENERATORS[name](n), preset, spacings.get(name), "textbook" not in missing))
    return PairsResult(where, preset, missing, cells, time.perf_counter() - start)


def _missing(preset: PairsPreset) -> dict[str, str]:
    """Return the peers that cannot be measured, and why."""
    missing = {}
    if importlib.util.find_spec("scipy") is None:
        missing["scipy"] = "is not installed: run  pip install './benchmarks[nearest]'"
    try:
        load_textbook()
    except FastlinesError as error:
        missing["textbook"] = f"is not compiled: {error}"
    if preset.n_threads > 1:
        missing["textbook"] = "has one thread"
    return missing


def _sizes(name: str, preset: PairsPreset) -> tuple[int, ...]:
    return (preset.n_crossing,) if name == "crossing" else preset.sizes


def _best_spacing(scene: ContactScene, preset: PairsPreset) -> float:
    """Return the spacing of samples with which scipy finds the pairs of a scene soonest."""
    edges = scene.lines.segments[:, 1] - scene.lines.segments[:, 0]
    longest = float(np.sqrt((edges**2).sum(axis=1)).max())
    best, least, spacing, n_slower = longest, math.inf, longest, 0
    while n_slower < N_SLOWER:
        find = SampledPairs(scene.lines, scene.radius, scene.skip_neighbours, spacing).find
        _, seconds = timed(find, clock(preset.n_threads))()
        if seconds < least:
            best, least, n_slower = spacing, seconds, 0
        else:
            n_slower += 1
        spacing /= 2
    return best


def _cell(scene: ContactScene, preset: PairsPreset, spacing: float | None, textbook: bool) -> PairsCell:
    lines, n = scene.lines, len(scene.lines)
    start = time.perf_counter()
    tree = build(lines)
    tree.layout  # noqa: B018
    build_s = time.perf_counter() - start
    sides: dict[str, Callable[[], Any]] = {
        "ours": partial(tree.pairs, scene.radius, skip_neighbours=scene.skip_neighbours, to="axis")
    }
    notes, builds = dict.fromkeys(PEERS, ""), dict.fromkeys(PEERS, 0.0)
    if spacing is not None and n <= preset.most_scipy:
        sampled = SampledPairs(lines, scene.radius, scene.skip_neighbours, spacing)
        sides["scipy"], builds["scipy"] = sampled.find, sampled.build_s
        notes["scipy"] = f"{sampled.n_samples:,} samples"
    if n <= preset.most_all_pairs:
        sides["all pairs"] = AllPairs(tree, scene.radius, scene.skip_neighbours).find
        if textbook:
            sides["textbook"] = partial(TextbookPairs(lines).find, scene.radius, scene.skip_neighbours)
    seconds, answers = take_turns(preset.rounds, sides, clock(preset.n_threads))
    ours = np.stack([answers["ours"].i, answers["ours"].j], axis=1)
    rivals = []
    for name in PEERS:
        if name in sides:
            n_differ = _differences(scene, name, ours, answers[name])
            ratio = median_ratio(seconds[name], seconds["ours"])
            took = statistics.median(seconds[name])
            rivals.append(PairsRival(name, notes[name], builds[name], took, ratio, n_differ))
    took = statistics.median(seconds["ours"])
    return PairsCell(scene.name, n, scene.radius, len(ours), build_s, took, tuple(rivals))


def _differences(scene: ContactScene, name: str, ours: IntArray, theirs: IntArray) -> int:
    """Return the number of pairs that one side alone has; raise an error if one is not at the radius."""
    n = len(scene.lines)
    keys = np.setxor1d(ours[:, 0] * n + ours[:, 1], theirs[:, 0] * n + theirs[:, 1], assume_unique=True)
    ends = scene.lines.segments.astype(np.float64)
    low, high = scene.lines.bounds.astype(np.float64)
    size = float(np.sqrt(((high - low) ** 2).sum()))
    if name == "all pairs" and len(keys):
        raise RuntimeError(
            f"{scene.name}, {n:,} segments: {len(keys)} pairs are found by a tree or by brute force alone"
        )
    off = np.abs(segment_distances(ends[keys // n], ends[keys % n]) - scene.radius)
    if len(keys) and off.max() > TOLERANCE * size:
        worst = int(keys[off.argmax()])
        raise RuntimeError(
            f"{scene.name}, {n:,} segments: the pair of {worst // n} and {worst % n} is found by one of ours and "
            f"{name} alone, although its distance differs from the radius by {off.max():.2g}"
        )
    return len(keys)
