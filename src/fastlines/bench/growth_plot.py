"""A picture of what a ray costs as the scene grows."""

from __future__ import annotations

import os

from .growth import Growth
from .labels import label_log
from .plot import check

#: One for each scene.
COLOURS = ("#c2410c", "#0369a1", "#15803d", "#7e22ce", "#a16207")

#: How kinds of rays are drawn, and queries.
LINES = {"camera": "-", "random": "--"}
MARKS = {"first": "o", "all": "s"}


def draw_growth(growth: Growth, path: str | os.PathLike[str]) -> None:
    """Draw the cost of a ray with the first thread count, a line for each scene, kind of rays and query, as a PNG."""
    check()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    plan = growth.plan
    exponents = {(fit.scene, fit.kind, fit.query): fit.cost[0] for fit in growth.fits()}
    figure = Figure(figsize=(9.0, 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    panel = figure.subplots()
    for names, cells in growth.groups().items():
        scene, kind, query = names
        panel.plot(
            [cell.n_segments for cell in cells],
            [cell.ns[0] for cell in cells],
            LINES[kind],
            marker=MARKS[query],
            color=COLOURS[plan.scenes.index(scene) % len(COLOURS)],
            label=f"{scene}, {kind}, {query}" + (f": $n^{{{exponents[names]:.2f}}}$" if names in exponents else ""),
        )
    panel.set_xscale("log")
    panel.set_yscale("log")
    for axis in (panel.xaxis, panel.yaxis):
        label_log(axis)
    panel.set_xlabel("segments")
    panel.set_ylabel("ns per ray")
    threads = plan.threads[0]
    panel.set_title(f"radius {plan.radius:g}, {threads} thread{'s' if threads > 1 else ''}", loc="left")
    panel.grid(color="#e2e8f0", linewidth=0.6)
    panel.set_axisbelow(True)
    panel.spines[["top", "right"]].set_visible(False)
    figure.legend(loc="outside right upper", frameon=False)
    figure.savefig(path, dpi=120, format="png")
