"""A picture of how far builders are from the optimum."""

from __future__ import annotations

import os

from .gap import INPUTS, Gaps, mean_and_worst
from .plot import check

#: One for each kind of input.
COLOURS = ("#c2410c", "#0369a1", "#15803d", "#7e22ce")


def draw_gap(gaps: Gaps, path: str | os.PathLike[str]) -> None:
    """Draw a point for each builder and input, a panel for each class of trees, as a PNG."""
    check()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    groups = gaps.groups()
    heights = [len(builders) + 1.5 for builders in groups.values()]
    figure = Figure(figsize=(9.0, 0.26 * sum(heights) + 1), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(groups), 1, squeeze=False, gridspec_kw={"height_ratios": heights})[:, 0]
    for panel, ((group, boxes, c_trav), builders) in zip(panels, groups.items(), strict=True):
        for (name, colour), shift in zip(zip(INPUTS, COLOURS, strict=True), (-0.24, -0.08, 0.08, 0.24), strict=True):
            points = [
                (c.ratio, i + shift) for i, cells in enumerate(builders.values()) for c in cells if c.scene == name
            ]
            panel.plot(*zip(*points, strict=True), ".", color=colour, alpha=0.6, markersize=4, label=name)
        means = [mean_and_worst(cells)[0] for cells in builders.values()]
        panel.plot(means, range(len(means)), "|", color="black", markersize=11, label="mean")
        panel.axvline(1.0, color="#94a3b8", linewidth=0.8, zorder=0)
        panel.set_yticks(range(len(builders)), list(builders), fontsize=7)
        panel.invert_yaxis()
        panel.set_title(f"{group}, {boxes} boxes, c_trav {c_trav:g}", loc="left", fontsize=9)
        panel.spines[["top", "right"]].set_visible(False)
    panels[-1].set_xlabel("cost in parts of the optimum")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", frameon=False)
    figure.savefig(path, dpi=120, format="png")
