"""One gather of the cube: by a query, by lists of hits and NumPy, by Embree, by a grid and by brute force, in turn."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from ..harness.clock import clock, median_ratio, timed
from ..harness.figures import Figures
from ..harness.findings import Check
from ..harness.internals import num_threads
from ..harness.rays import RayBatch
from ..peers.beam_loops import BeamGrid, brute_force
from ..peers.embree import Scenes
from .cube import Cube, make_cube, radius_of
from .memory import peak_bytes
from .rebuilt import MOST_DIFFERENT, build_tree, difference
from .tuned import fastest, tune_embree, tune_grid

#: The peers' times divided by ours that are wanted at least, from so many beams on; the same of lists and NumPy.
FASTER, FROM, FASTER_THAN_LISTS = 4.0, 1_000_000, 2.0

#: The share of the memory of lists that is wanted at most.
LESS_MEMORY = 0.1

#: The bytes of the parts in which hits are listed while they are timed.
LIST_BYTES = 1 << 30

LISTS = "lists + NumPy"


@dataclass(frozen=True)
class GatherSize:
    """How large the gathers are.

    Parameters
    ----------
    beams : tuple of int
        Numbers of beams.
    size : int
        The width of the picture.
    peer_rays, listed_rays, brute_rays : int
        About how many rays Embree and the grid get, are listed, and get brute force: windows of the picture.
    memory_rays : int
        About how many rays are gathered to measure the memory.
    method : str
        How our tree is built.
    """

    beams: tuple[int, ...]
    size: int
    peer_rays: int
    listed_rays: int
    brute_rays: int
    memory_rays: int
    method: str
    rounds: int
    floors: bool
    n_threads: int


@dataclass(frozen=True)
class Side:
    """A way to gather: what it is, the seconds and the memory of what it builds, its function, and the rays it gets."""

    what: str
    build_s: float
    megabytes: float | None
    gather: Callable[[RayBatch], Any]
    rays: RayBatch

    @property
    def columns(self) -> tuple[str, float, float | None, int]:
        """The columns of a table that say what it is."""
        return self.what, self.build_s, self.megabytes, len(self.rays)


def run_gather(size: GatherSize, progress: Callable[[str, float], None]) -> Figures:
    """Gather cubes of some numbers of beams by all sides in turn."""
    rows: list[tuple[Any, ...]] = []
    checks: list[Check] = []
    notes: list[str] = []
    for i, n in enumerate(size.beams):
        radius = radius_of(n)

        def say(what: str, share: float, i: int = i, n: int = n) -> None:
            progress(f"{n:,} beams: {what}", (i + share) / len(size.beams))

        say("tracing photons", 0.0)
        cube = make_cube(n, size.size)
        with num_threads(size.n_threads):
            ours, peers, n_hits = _sides(cube, radius, size, say)
            whole, seconds, differ = _turns(ours, peers, size, say)
        say("memory", 0.95)
        peaks = [peak_bytes(way, n, size.size, size.memory_rays, radius, size.method) for way in ("gather", "lists")]
        rows.append((n, f"{radius:g}", "ours", *ours.columns, statistics.median(whole), None, None, None))
        scene, ratios = f"{n:,} beams", {}
        for name, side in peers.items():
            theirs, mine = seconds[name]
            ratios[name] = median_ratio(theirs, mine)
            times = statistics.median(theirs), statistics.median(mine), ratios[name]
            rows.append((n, f"{radius:g}", name, *side.columns, *times, f"{differ[name]:.1e}"))
            checks.append(Check(f"difference of {name} from ours", differ[name], MOST_DIFFERENT, scene=scene))
        if size.floors:
            checks.append(Check("time of lists and NumPy by ours", ratios[LISTS], least=FASTER_THAN_LISTS, scene=scene))
        if size.floors and n >= FROM:
            best = min(ratio for name, ratio in ratios.items() if name != LISTS)
            checks.append(Check("time of the best other peer by ours", best, least=FASTER, scene=scene))
        if peaks[0] is not None and peaks[1]:
            if size.floors:
                checks.append(Check("our memory by that of lists", peaks[0] / peaks[1], LESS_MEMORY, scene=scene))
            notes.append(
                f"{scene}: {n_hits / len(cube.rays):.0f} hits a ray. About {size.memory_rays:,} of the rays take "
                f"{peaks[0] / 1e6:.1f} MB by a gather, and {peaks[1] / 1e6:.1f} MB by one list of all hits and NumPy."
            )
    heads = ("beams", "radius", "side", "what", "build, s", "MB", "rays", "seconds", "ours, s", "by ours", "differs")
    notes.append(
        f"{size.size}² rays; sides with fewer get windows of the picture, and ours gets the same. Epanechnikov's "
        f"kernel, three colours. Medians of {size.rounds} rounds in turn, {size.n_threads} thread(s). MB are those of "
        "the tree or the grid."
    )
    return Figures("gather", "one gather of the cube", heads, rows, notes, checks)


def _sides(
    cube: Cube, radius: float, size: GatherSize, say: Callable[[str, float], None]
) -> tuple[Side, dict[str, Side], int]:
    """Build all sides, the peers with the settings that are fastest; return ours, the peers, and the number of hits."""
    given, rays, powers, n_threads = cube.gathering(radius), cube.rays, cube.powers, size.n_threads
    now = clock(n_threads)

    say("building ours", 0.1)
    tree, tree_s = build_tree(cube, size.method, n_threads)
    n_hits = int(tree.count_hits(rays.origins, rays.directions, radius).sum())
    ours = Side(size.method, tree_s, tree.layout.n_bytes / 1e6, lambda part: given.ours(tree, part, powers), rays)
    say("trying configurations of Embree", 0.2)
    config = fastest(tune_embree(cube, given, n_threads, ("high",))).choice
    scenes = Scenes(cube.lines, radius, (0, 0, 0), n_threads)
    scene = scenes.get(config.build)
    say("trying grids", 0.3)
    cells = fastest(tune_grid(cube, given, n_threads)).choice
    grid, grid_s = timed(partial(BeamGrid, cube.lines, radius, cells), now)()
    peers = {
        LISTS: Side(
            size.method,
            tree_s,
            None,
            lambda part: given.listed(tree, cube.lines, part, powers, LIST_BYTES),
            rays.part(size.listed_rays),
        ),
        "Embree": Side(
            str(config),
            scenes.build_seconds(config.build),
            scene.bytes / 1e6,
            lambda part: scenes.gather(config, given, part, powers),
            rays.part(size.peer_rays),
        ),
        "grid": Side(
            f"{cells} cells a side",
            grid_s,
            grid.bytes / 1e6,
            lambda part: grid.gather(given, part, powers, n_threads),
            rays.part(size.peer_rays),
        ),
        "brute force": Side(
            "16 beams at a time",
            0.0,
            None,
            lambda part: brute_force(cube.lines, given, part, powers, n_threads),
            rays.part(size.brute_rays),
        ),
    }
    return ours, peers, n_hits


def _turns(
    ours: Side, peers: dict[str, Side], size: GatherSize, say: Callable[[str, float], None]
) -> tuple[list[float], dict[str, tuple[list[float], list[float]]], dict[str, float]]:
    """Run all sides in turn.

    Returns
    -------
    whole : list of float
        Our seconds of each round, for all rays.
    seconds : dict of str to (list of float, list of float)
        The seconds of each round of a peer, and ours for the same rays.
    differ : dict of str to float
        The sum of all absolute differences between a peer's sums and ours, by the sum of ours.
    """
    now = clock(size.n_threads)
    seconds: dict[str, tuple[list[float], list[float]]] = {name: ([], []) for name in peers}
    whole, differ = [], {}
    for i in range(size.rounds):
        whole.append(timed(partial(ours.gather, ours.rays), now)()[1])
        known: dict[int, tuple[Any, float]] = {}  # ours, by the number of rays
        for j, (name, side) in enumerate(peers.items()):
            say(f"{name}, round {i + 1} of {size.rounds}", 0.4 + 0.5 * (i + j / len(peers)) / size.rounds)
            part = side.rays
            if len(part) not in known:
                known[len(part)] = timed(partial(ours.gather, part), now)()
            mine, my_seconds = known[len(part)]
            theirs, their_seconds = timed(partial(side.gather, part), now)()
            seconds[name][0].append(their_seconds)
            seconds[name][1].append(max(my_seconds, 1e-9))
            differ[name] = difference(mine, theirs)
    return whole, seconds, differ
