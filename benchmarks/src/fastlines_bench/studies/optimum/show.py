"""The tables of the ratios to the optimum, and a plot of all inputs."""

from __future__ import annotations

import os

from ...harness.plot import new_figure, save, style
from ...harness.tables import new_table, print_table, wide_console
from .gap import INPUTS, Gaps, mean_and_worst

#: The colour of each kind of input.
COLOURS = ("#c2410c", "#0369a1", "#15803d", "#7e22ce")


def print_gaps(gaps: Gaps) -> None:
    """Print a table for each class of trees."""
    console = wide_console()
    preset = gaps.preset
    sizes = {
        "same planes": f"{preset.same_planes[0]} segments, the same {preset.same_planes[1]} planes an axis for both",
        "sets": f"{preset.sets} segments, none of them cut",
        "builders": f"{preset.builders[0]} segments, the optimum over {preset.builders[1]} planes an axis",
    }
    for (group, boxes, c_trav), builders in gaps.groups().items():
        title = f"{group}: {boxes} boxes, c_trav {c_trav:g}; {sizes[group]}"
        table = new_table(title, [""], [*INPUTS, "mean", "worst"])
        for builder, cells in builders.items():
            means = [mean_and_worst([cell for cell in cells if cell.scene == name])[0] for name in INPUTS]
            table.add_row(builder, *(f"{ratio:.3f}" for ratio in (*means, *mean_and_worst(cells))))
        print_table(console, table)
    console.print(
        f"Costs as multiples of the optimum, geometric means of {preset.n_seeds} inputs each. The core's builders "
        "place planes over each node's own box, and some have object splits, so they can beat the optimum of a fixed "
        "grid.",
        highlight=False,
    )


def draw_gap(gaps: Gaps, path: str | os.PathLike[str]) -> None:
    """Plot a point for each builder and input, a panel for each class of trees, as a PNG."""
    groups = gaps.groups()
    heights = [len(builders) + 1.5 for builders in groups.values()]
    figure = new_figure(9.0, 0.26 * sum(heights) + 1)
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
        style(panel)
    panels[-1].set_xlabel("cost / optimum")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", frameon=False)
    save(figure, path)
