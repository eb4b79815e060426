"""Several radii over the same beams: one tree, and Embree's scene, rebuilt for each or built for the largest."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ..harness.clock import clock, timed
from ..harness.figures import Figures
from ..harness.findings import Check
from ..harness.internals import num_threads
from ..peers.embree import Scenes
from .cube import make_cube
from .rebuilt import MOST_DIFFERENT, best_config, build_tree, difference, gather_embree
from .tuned import fastest, tune_embree


def run_radii(
    n_beams: int,
    radii: tuple[float, ...],
    size: int,
    method: str,
    n_threads: int,
    progress: Callable[[str, float], None],
) -> Figures:
    """Gather the same beams with some radii, in a picture of size² pixels."""
    now, largest = clock(n_threads), max(radii)
    with num_threads(n_threads):
        progress("radii: trying configurations of Embree", 0.0)
        cube = make_cube(n_beams, size)
        rebuilt = best_config(cube, largest, n_threads)
        kept = fastest(tune_embree(cube, cube.gathering(min(radii)), n_threads, ("high",), largest)).choice
        tree, tree_s = build_tree(cube, method, n_threads)
        scenes = Scenes(cube.lines, largest, (0, 0, 0), n_threads)
        kept_s = scenes.build_seconds(kept.build)
        rows, worst = [], 0.0
        for i, radius in enumerate(radii):
            progress(f"radius {radius:g}", (i + 1) / (len(radii) + 1))
            given = cube.gathering(radius)
            mine, ours_s = timed(partial(given.ours, tree, cube.rays, cube.powers), now)()
            theirs = gather_embree(cube, radius, rebuilt, n_threads)
            other, other_s = timed(partial(scenes.gather, kept, given, cube.rays, cube.powers), now)()
            worst = max(worst, difference(mine, theirs.sums), difference(mine, other))
            rows.append((f"{radius:g}", ours_s, theirs.build_s, theirs.gather_s, other_s))
    heads = (
        "radius",
        "ours, s",
        "Embree rebuilt: build, s",
        "its gather, s",
        "Embree built for the largest: gather, s",
    )
    what = f"{n_beams:,} beams"
    ours_s = tree_s + sum(row[1] for row in rows)
    rebuilt_s, once_s = sum(row[2] + row[3] for row in rows), kept_s + sum(row[4] for row in rows)
    notes = [
        f"{what}, {size}² rays, {n_threads} thread(s). Our tree ({method}) is built once, in {tree_s:.2f} s; Embree's "
        f"scene for the largest radius ({kept}) in {kept_s:.2f} s; rebuilt: {rebuilt}. All with their builds: ours "
        f"{ours_s:.2f} s, rebuilt {rebuilt_s:.2f} s ({rebuilt_s / ours_s:.2f} times), built once {once_s:.2f} s "
        f"({once_s / ours_s:.2f} times)."
    ]
    checks = [Check("largest difference of a radius", worst, MOST_DIFFERENT, scene=what)]
    return Figures("radii", "several radii over the same beams", heads, rows, notes, checks)
