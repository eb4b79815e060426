"""The tables of all builders and checks, and a plot of cost and query time against build time."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from rich.table import Table

from ..harness.findings import Check
from ..harness.plot import label_log, name_points, new_figure, save, style
from ..harness.rays import QUESTIONS
from ..harness.tables import format_3_digits, new_table, print_table, wide_console
from .names import THESIS_COST
from .rows import BuilderRow
from .run import BuildersResult, front

COLOURS = {"bvh": "#c2410c", "kd": "#0369a1"}
MARKS = {"bvh": "o", "kd": "s"}
#: The colours of the sweeps.
SWEEPS = {"best": "#15803d", "best-bvh": "#a16207", "best-kd": "#7e22ce"}


def print_builders(result: BuildersResult) -> None:
    """Print a table for each scene, with a row for each builder, then the checks."""
    console = wide_console()
    scenes = result.scenes()
    for scene in dict.fromkeys([*scenes, *(over.scene for over in result.over)]):
        print_table(console, _measured(result, scene, scenes.get(scene, [])))
    if result.rows:
        print_table(console, _checks(result.checks()))
    preset = result.preset
    costs = ", ".join(f"{cost.c_trav:g} ({kind})" for kind, cost in THESIS_COST.items())
    threads = f"{preset.n_threads} thread{'s' if preset.n_threads > 1 else ''}"
    peer = f"Embree {result.machine['embree']}: the build with the fastest queries. " if preset.peer else ""
    console.print(
        f"{threads}. cost: with the builder's own c_trav; alike: with c_trav {costs} for all. build: the median "
        f"of up to {preset.rounds}. Queries: ns per ray, the best of {preset.rounds}; mean: geometric, of the four. *: "
        "on the Pareto front of build and mean query time. over: did not end within "
        f"{preset.limit:g} s, so it has no other figures. {peer}All answers are the same, bit for bit. "
        f"{result.seconds:.0f} s in all.",
        highlight=False,
    )


def _measured(result: BuildersResult, scene: str, rows: Sequence[BuilderRow]) -> Table:
    segments = f": {rows[0].n_segments:,} segments" if rows else ""
    heads = ["references", "nodes", "cost", "alike", "build\ns", "layout\ns"]
    heads += ["\n".join(question) for question in QUESTIONS] + ["mean"]
    table = new_table(f"{scene}{segments}", ["builder"], heads)
    ahead = front([(row.build_s, row.query_ns) for row in rows])
    for i, row in enumerate(rows):
        table.add_row(row.builder, *_cells(row, i in ahead))
    for over in result.over:
        if over.scene == scene:
            table.add_row(over.builder, f"over {over.seconds:g} s")
    for peer in result.peers:
        if peer.scene == scene:
            table.add_row("Embree", "", "", "", "", format_3_digits(peer.build_s))
    return table


def _cells(row: BuilderRow, ahead: bool) -> list[str]:
    return [
        f"{row.n_refs:,}",
        f"{row.n_nodes:,}",
        _cost(row.cost),
        _cost(row.thesis_cost),
        format_3_digits(row.build_s),
        format_3_digits(row.layout_s),
        *(f"{ns:,.0f}" for ns in row.ns.values()),
        f"{row.query_ns:,.0f}{'*' if ahead else ' '}",
    ]


def _cost(cost: float) -> str:
    return f"{cost:,.1f}" if cost >= 99.5 else f"{cost:.2f}"


def _checks(checks: Sequence[Check]) -> Table:
    table = new_table("what ought to hold", ["scene"], [], [""])
    for head in ("measured", "at most"):
        table.add_column(head, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for check in checks:
        figures = ["–" if value is None else f"{value:,.4g}" for value in (check.figure, check.most)]
        said = {True: "holds", False: "[red]does not hold[/]", None: "not measured"}[check.holds]
        table.add_row(check.scene, check.what, *figures, said)
    return table


def draw_builders(result: BuildersResult, path: str | os.PathLike[str]) -> None:
    """Plot two panels for each scene, as a PNG."""
    scenes = result.scenes()
    figure = new_figure(12.0, 4.0 * max(1, len(scenes)))
    panels = figure.subplots(max(1, len(scenes)), 2, squeeze=False)
    peers = {peer.scene: peer.build_s for peer in result.peers}
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
            style(panel, grid=True)
            panel.legend(loc="upper right", frameon=False, fontsize=7)
            panel.margins(0.08)
            for axis in (panel.xaxis, panel.yaxis):
                label_log(axis)
    figure.draw_without_rendering()  # fixes the layout of the panels
    for (cost, query), rows in zip(panels, scenes.values(), strict=False):
        for panel, heights in ((cost, [row.thesis_cost for row in rows]), (query, [row.query_ns for row in rows])):
            name_points(
                panel, [(row.build_s, y) for row, y in zip(rows, heights, strict=True)], [_name(row) for row in rows]
            )
    save(figure, path)


def _points(panel: Any, rows: Sequence[BuilderRow], heights: Sequence[float], colour: str, label: str) -> None:
    """Plot the trees of some builders, a line through their Pareto front, and one through each sweep."""
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


def _name(row: BuilderRow) -> str:
    """Return the label of a point: the builder, or only the part from the @ for a sweep, whose line has the name."""
    _, at, place = row.builder.partition("@")
    return at + place if at else row.builder


def sweeps(rows: Sequence[BuilderRow]) -> dict[str, list[int]]:
    """Return the indices of the rows of each sweep, by the name before the @ of builders such as best@0.5."""
    found: dict[str, list[int]] = {}
    for i, row in enumerate(rows):
        family, at, _ = row.builder.partition("@")
        if at:
            found.setdefault(family, []).append(i)
    return found
