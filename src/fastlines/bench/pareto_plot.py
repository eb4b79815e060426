"""A picture of all builders: build time against cost and against query time, with the front that none is beyond."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from .builders import THESIS_COST
from .labels import label_log, name_points
from .pareto import Pareto, Row, front
from .plot import check

COLOURS = {"bvh": "#c2410c", "kd": "#0369a1"}
MARKS = {"bvh": "o", "kd": "s"}
#: One for each sweep.
SWEEPS = {"best": "#15803d", "best-bvh": "#a16207", "best-kd": "#7e22ce"}


def draw_pareto(pareto: Pareto, path: str | os.PathLike[str]) -> None:
    """Draw two panels for each scene, and write them as a PNG."""
    check()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    scenes = pareto.scenes()
    figure = Figure(figsize=(12.0, 4.0 * max(1, len(scenes))), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(max(1, len(scenes)), 2, squeeze=False)
    peers = {peer.scene: peer.build_s for peer in pareto.peers}
    for (cost, query), (scene, rows) in zip(panels, scenes.items(), strict=False):
        for kind, model in THESIS_COST.items():
            of_kind = [row for row in rows if row.kind == kind]
            _points(
                cost, of_kind, [row.thesis_cost for row in of_kind], COLOURS[kind], f"{kind}, c_trav {model.c_trav:g}"
            )
        _points(query, rows, [row.query_ns for row in rows], "#64748b", "all builders")
        cost.set_ylabel("cost")
        query.set_ylabel("ns a ray, geometric mean")
        for panel in (cost, query):
            if scene in peers:
                panel.axvline(peers[scene], color="#a3a3a3", linestyle=":", label="Embree's build")
            panel.set_xscale("log")
            panel.set_yscale("log")
            panel.set_xlabel("build, s")
            panel.set_title(scene, loc="left")
            panel.grid(color="#e2e8f0", linewidth=0.6)
            panel.set_axisbelow(True)
            panel.spines[["top", "right"]].set_visible(False)
            panel.legend(loc="upper right", frameon=False, fontsize=7)
            panel.margins(0.08)
            for axis in (panel.xaxis, panel.yaxis):
                label_log(axis)
    figure.draw_without_rendering()  # gives panels their place
    for (cost, query), rows in zip(panels, scenes.values(), strict=False):
        for panel, heights in ((cost, [row.thesis_cost for row in rows]), (query, [row.query_ns for row in rows])):
            name_points(
                panel, [(row.build_s, y) for row, y in zip(rows, heights, strict=True)], [_name(row) for row in rows]
            )
    figure.savefig(path, dpi=120, format="png")


def _points(panel: Any, rows: Sequence[Row], heights: Sequence[float], colour: str, label: str) -> None:
    """Draw the trees of some builders, the front in one line, and each sweep in one."""
    if not rows:
        return
    points = [(row.build_s, height) for row, height in zip(rows, heights, strict=True)]
    ahead = [points[i] for i in front(points)]
    panel.plot(*zip(*ahead, strict=True), "-", color=colour, label=f"{label}: front", linewidth=1.2)
    for family, places in sweeps(rows).items():
        panel.plot(
            *zip(*(points[i] for i in places), strict=True),
            "--",
            color=SWEEPS[family],
            label=f"{family}@…",
            linewidth=0.9,
        )
    for row, point in zip(rows, points, strict=True):
        panel.plot(*point, MARKS[row.kind], color=COLOURS[row.kind], markersize=4)


def _name(row: Row) -> str:
    """What stands beside its point: of a place on a sweep, whose line has a name, only which place it is."""
    _, at, place = row.builder.partition("@")
    return at + place if at else row.builder


def sweeps(rows: Sequence[Row]) -> dict[str, list[int]]:
    """The places of each sweep among the rows: builders such as best@0.5, by what stands before the @."""
    found: dict[str, list[int]] = {}
    for i, row in enumerate(rows):
        family, at, _ = row.builder.partition("@")
        if at:
            found.setdefault(family, []).append(i)
    return found
