"""Progressive passes: new beams and a smaller radius each, with our tree and Embree's scene built for each."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from functools import partial

from ..harness.clock import clock, timed
from ..harness.figures import Figures
from ..harness.findings import Check
from ..harness.internals import num_threads
from .cube import make_cube
from .rebuilt import MOST_DIFFERENT, best_config, best_method, difference, gather_embree, gather_ours

#: The exponent of progressive passes: R of pass i + 1 is R of pass i times (i + α)/(i + 1).
ALPHA = 0.7

#: Embree's time of a pass by ours that is wanted at least.
FASTER = 4.0


def run_passes(
    n_beams: int,
    n_passes: int,
    radius: float,
    size: int,
    methods: Sequence[str],
    floors: bool,
    n_threads: int,
    progress: Callable[[str, float], None],
) -> Figures:
    """Run passes of so many beams each, from a radius on, for a picture of size² pixels, by both sides in turn."""
    with num_threads(n_threads):
        progress("passes: trying methods and configurations", 0.0)
        first = make_cube(n_beams, size)
        method = best_method(first, radius, methods, n_threads)
        config = best_config(first, radius, n_threads)
        points = []
        for i in range(n_passes):
            progress(f"pass {i + 1} of {n_passes}", (i + 1) / (n_passes + 1))
            cube, traced_s = timed(partial(make_cube, n_beams, size, i), clock(n_threads))()
            ours = gather_ours(cube, radius, method, n_threads)
            theirs = gather_embree(cube, radius, config, n_threads)
            points.append(
                {
                    "radius": radius,
                    "trace_s": traced_s,
                    "our_build_s": ours.build_s,
                    "our_gather_s": ours.gather_s,
                    "ours_s": ours.seconds,
                    "embree_build_s": theirs.build_s,
                    "embree_gather_s": theirs.gather_s,
                    "embree_s": theirs.seconds,
                    "ratio": theirs.seconds / ours.seconds,
                    "difference": difference(ours.sums, theirs.sums),
                }
            )
            radius *= (i + 1 + ALPHA) / (i + 2)
    columns = "our_build_s", "our_gather_s", "embree_build_s", "embree_gather_s", "ratio"
    rows = [
        (i + 1, f"{each['radius']:.5f}", *(each[name] for name in columns), f"{each['difference']:.1e}")
        for i, each in enumerate(points)
    ]
    heads = ("pass", "radius", "our build, s", "our gather, s", "Embree's build, s", "Embree's gather, s", "by ours")
    scene = f"{n_beams:,} beams a pass"
    names = "ours_s", "embree_s", "trace_s", "our_gather_s"
    ours_s, theirs_s, trace_s, gather_s = (sum(each[name] for each in points) for name in names)
    ratios = [each["ratio"] for each in points]
    notes = [
        f"{scene}, {size}² rays, {n_threads} thread(s). Our method: {method}, the best of {', '.join(methods)}; "
        f"Embree: {config}. All passes: ours {ours_s:.1f} s, Embree {theirs_s:.1f} s, {theirs_s / ours_s:.2f} times; a "
        f"pass: {min(ratios):.2f} to {max(ratios):.2f}. The tracing of photons takes {trace_s:.1f} s more. Gathers are "
        f"{gather_s / (ours_s + trace_s):.0%} of our passes with tracing."
    ]
    worst = max(each["difference"] for each in points)
    checks = [Check("largest difference of a pass", worst, MOST_DIFFERENT, scene=scene)]
    if floors:
        median = statistics.median(ratios)
        checks.append(Check("Embree's time of a pass by ours, median", median, least=FASTER, scene=scene))
    return Figures("passes", "progressive passes", (*heads, "differs"), rows, notes, checks, points)
