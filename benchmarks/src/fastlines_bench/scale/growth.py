"""How time grows with segments, rays and tiles, as powers."""

from __future__ import annotations

import os
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import fastlines as fl

from ..engine.growth.run import exponent
from ..harness.figures import Figures
from ..harness.plot import label_log, new_figure, save, style
from . import streamlines
from .answers import most_segments
from .questions import RADIUS

#: The rays of one call: more are traced in several calls, so that rays and hits need no memory.
AT_ONCE = 4_000_000


def run_growth(
    sizes: tuple[int, ...], rays: tuple[int, ...], tiles: tuple[int, ...], n_segments: int, n_rays: int, progress: Any
) -> Figures:
    """Time builds and first hits: for growing numbers of segments, of rays, and of tiles, with the others fixed."""
    points: list[dict[str, Any]] = []
    with TemporaryDirectory(prefix="fastlines-bench-") as temporary:

        def forest_of(n: int, n_tiles: int) -> tuple[Any, float]:
            folder, begin = Path(temporary) / f"{n}-{n_tiles}", time.perf_counter()
            if (folder / "forest.json").exists():
                return fl.Forest(folder), np.nan
            made = fl.build_forest(streamlines.chunks(n), folder, max_segments=most_segments(n, n_tiles))
            return made, time.perf_counter() - begin

        middle_tiles = 16
        for n in sizes:
            progress(f"growth: {n:,} segments", 0.1)
            forest, built = forest_of(n, middle_tiles)
            points.append(_point("segments", n, forest, built, n_rays))
            if n != n_segments:
                _remove(forest)
        forest, _ = forest_of(n_segments, middle_tiles)
        for n in rays:
            progress(f"growth: {n:,} rays", 0.4)
            points.append(_point("rays", n, forest, np.nan, n))
        for n_tiles in tiles:
            progress(f"growth: {n_tiles} tiles", 0.8)
            forest, built = forest_of(n_segments, n_tiles)
            points.append(_point("tiles", n_tiles, forest, built, n_rays))
    rows = [
        (
            point["what"],
            point["size"],
            point["n_tiles"],
            point["build_s"],
            point["first_s"],
            point["rays"] / point["first_s"] / 1e6,
        )
        for point in points
    ]
    fits = {
        what: _exponents([point for point in points if point["what"] == what]) for what in ("segments", "rays", "tiles")
    }
    notes = [f"{what}: build ~ n^{build}, first hits ~ n^{first}." for what, (build, first) in fits.items()]
    notes.append(
        f"Random rays, radius {RADIUS:g}; {n_rays:,} rays where segments or tiles grow, {n_segments:,} segments where "
        "rays or tiles grow, about 16 tiles where segments or rays grow. One run of each, after one that opens tiles."
    )
    heads = ("what grows", "n", "tiles", "build, s", "first hits, s", "Mrays/s")
    return Figures("growth", "how time grows", heads, rows, notes, [], points)


def _point(what: str, size: int, forest: Any, built: float, n_rays: int) -> dict[str, Any]:
    forest.first_hit(*streamlines.rays(1 << 14), RADIUS)
    seconds = 0.0
    for seed, begin in enumerate(range(0, n_rays, AT_ONCE)):
        rays = streamlines.rays(min(AT_ONCE, n_rays - begin), seed)
        start = time.perf_counter()
        forest.first_hit(*rays, RADIUS)
        seconds += time.perf_counter() - start
    found = {"what": what, "size": size, "n_tiles": forest.n_tiles, "rays": n_rays, "first_s": seconds}
    return {**found, "build_s": None if np.isnan(built) else built}


def _exponents(points: list[dict[str, Any]]) -> tuple[str, str]:
    """Return the exponents of builds and of first hits, in words."""
    texts = []
    for name in ("build_s", "first_s"):
        known = [(point["size"], point[name]) for point in points if point[name] is not None]
        texts.append(f"{exponent(*zip(*known, strict=True)):.2f}" if len(known) > 1 else "…")
    return texts[0], texts[1]


def _remove(forest: Any) -> None:
    import shutil

    shutil.rmtree(forest.path)


def draw_growth(figures: Figures, path: str | os.PathLike[str]) -> None:
    """Plot times against segments, rays and tiles, as a PNG."""
    figure = new_figure(10.0, 3.6)
    panels = figure.subplots(1, 3)
    for panel, what in zip(panels, ("segments", "rays", "tiles"), strict=True):
        points = [point for point in figures.points if point["what"] == what]
        for name, label, colour in (("build_s", "build", "#c2410c"), ("first_s", "first hits", "#0369a1")):
            known = [(point["size"], point[name]) for point in points if point[name] is not None]
            if known:
                panel.plot(*zip(*known, strict=True), "o-", color=colour, label=label, markersize=4)
        panel.set(xscale="log", yscale="log", xlabel=what)
        style(panel, grid=True)
        if what == "tiles":
            label_log(panel.xaxis)
        label_log(panel.yaxis)
    panels[0].set_ylabel("seconds")
    panels[0].legend(frameon=False)
    save(figure, path)
