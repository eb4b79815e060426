"""The plot: the closed form, the times of passes, and the caustic with its error over time."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ..harness.figures import Figures
from ..harness.internals import srgb, to_bytes
from ..harness.plot import label_log, new_figure, save, style
from .caustic import OURS, REFERENCE, THEIRS
from .run import BeamsResult

#: The parts that are drawn.
DRAWN = ("point-light", "passes", "caustic")

OUR_COLOUR, THEIR_COLOUR = "#c2410c", "#0369a1"


def draw_beams(result: BeamsResult, path: str | os.PathLike[str]) -> None:
    """Draw a row for each part of `DRAWN` that was measured, as a PNG."""
    parts = [part for part in result.parts if part.name in DRAWN]
    figure = new_figure(10.0, 3.6 * len(parts))
    rows = figure.subfigures(len(parts), 1, squeeze=False)[:, 0]
    for row, part in zip(rows, parts, strict=True):
        {"point-light": _draw_point_light, "passes": _draw_passes, "caustic": _draw_caustic}[part.name](row, part)
    save(figure, path)


def _draw_point_light(figure: Any, part: Figures) -> None:
    """Draw means and theory as fractions of the closed form, a panel for each radius."""
    names = [name for name in part.points[0] if name.startswith("theory ")]
    for panel, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
        radius = name.removeprefix("theory ")
        b = [point["b"] for point in part.points]
        panel.plot(b, [point[name] for point in part.points], "-", color="#334155", label="blurred closed form")
        for kind, colour, shift in (("long", OUR_COLOUR, 0.98), ("short", THEIR_COLOUR, 1.02)):
            mean, error = zip(*(point[f"{kind} {radius}"] for point in part.points), strict=True)
            panel.errorbar(
                np.multiply(b, shift), mean, error, fmt="o", markersize=3, color=colour, label=f"{kind} beams"
            )
        panel.set(xscale="log", xlabel="distance from the light", title=f"R = {radius}")
        panel.set_ylabel("radiance by the closed form")
        label_log(panel.xaxis)
        style(panel, grid=True)
        panel.legend(frameon=False)


def _draw_passes(figure: Any, part: Figures) -> None:
    panel = figure.subplots(1, 1)
    numbers = range(1, len(part.points) + 1)
    for name, label, colour in (("ours_s", "fastlines", OUR_COLOUR), ("embree_s", "Embree", THEIR_COLOUR)):
        panel.plot(numbers, [point[name] for point in part.points], "o-", markersize=3, color=colour, label=label)
    panel.set(xlabel="pass", ylabel="seconds of build and gather", title=part.title)
    panel.set_ylim(bottom=0)
    panel.xaxis.get_major_locator().set_params(integer=True)
    style(panel, grid=True)
    panel.legend(frameon=False)


def _draw_caustic(figure: Any, part: Figures) -> None:
    """Draw the error over time, and the three pictures."""
    panels = figure.subplots(1, 4, width_ratios=(1.6, 1, 1, 1))
    for side, colour in ((OURS, OUR_COLOUR), (THEIRS, THEIR_COLOUR)):
        points = [point for point in part.points if point["side"] == side]
        if points:
            curve = [[point["seconds"], point["rmse"]] for point in points]
            panels[0].plot(*zip(*curve, strict=True), "o-", markersize=3, color=colour, label=side)
    panels[0].set(xscale="log", yscale="log", xlabel="seconds", ylabel="RMSE by the mean")
    label_log(panels[0].xaxis)
    label_log(panels[0].yaxis)
    style(panels[0], grid=True)
    panels[0].legend(frameon=False)
    brightest = np.quantile(part.pictures[REFERENCE], 0.995)
    for panel, (name, picture) in zip(panels[1:], part.pictures.items(), strict=True):
        panel.imshow(to_bytes(srgb(np.clip(picture / brightest, 0, 1))))
        panel.set_title(name)
        panel.axis("off")
