"""Plots: figures without a window, labels of logarithmic axes, and names of points that do not overlap."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from fastlines import FastlinesError

#: Offsets of a name from its point: x and y in typographic points, and 1 if the name is right of it, −1 if left.
#: Earlier offsets are preferred.
PLACES = [
    (sign * (4 + 6 * ring), y, sign) for ring in range(5) for y in (2 + 8 * ring, -6 - 8 * ring) for sign in (1, -1)
]


def check() -> None:
    """Raise an error if matplotlib is missing, before any work is done."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise FastlinesError("a plot needs matplotlib: run  pip install matplotlib") from None


def new_figure(width: float, height: float) -> Any:
    """Return a figure that needs no window."""
    check()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Any, path: str | os.PathLike[str]) -> None:
    """Write a figure as a PNG."""
    figure.savefig(path, dpi=120, format="png")


def style(panel: Any, grid: bool = False) -> None:
    """Hide the top and right edges of a panel, and draw a grid if `grid`."""
    panel.spines[["top", "right"]].set_visible(False)
    if grid:
        panel.grid(color="#e2e8f0", linewidth=0.6)
        panel.set_axisbelow(True)


def label_log(axis: Any) -> None:
    """Label a logarithmic axis in plain numbers: at 1, 10, 100, or 1, 2, 5, 10, or evenly, to have three labels."""
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

    low, high = sorted(axis.get_view_interval())
    locators = (LogLocator(), LogLocator(subs=(1, 2, 5)), MaxNLocator(6))
    enough = (each for each in locators if sum(low <= tick <= high for tick in each.tick_values(low, high)) >= 3)
    axis.set_major_locator(next(enough, locators[-1]))
    axis.set_major_formatter(FuncFormatter(lambda figure, _: f"{figure:,.10g}"))
    axis.set_minor_formatter(NullFormatter())


def name_points(panel: Any, points: Sequence[tuple[float, float]], names: Sequence[str], size: float = 6.0) -> None:
    """Write a name next to each point of a panel whose layout is fixed, with a thin line between them.

    Names are placed from left to right. Each takes the first offset at which it overlaps no name, no point and not the
    panel's edge, or else the offset with the least overlap.
    """
    from matplotlib.text import Text
    from matplotlib.transforms import Bbox

    renderer = panel.figure.canvas.get_renderer()
    taken = [Bbox.from_bounds(x - 3, y - 3, 6, 6) for x, y in panel.transData.transform(points)]
    line = {"arrowstyle": "-", "linewidth": 0.4, "color": "#94a3b8", "shrinkA": 0, "shrinkB": 1}
    for i in sorted(range(len(points)), key=lambda i: points[i]):
        label = panel.annotate(names[i], points[i], (0, 0), textcoords="offset points", fontsize=size, arrowprops=line)
        label.set_in_layout(False)

        def covered(place: tuple[int, int, int], label: Any = label) -> float:
            x, y, sign = place
            label.set(position=(x, y), horizontalalignment="left" if sign > 0 else "right")
            label.update_positions(renderer)
            box = Text.get_window_extent(label, renderer)
            inside = Bbox.intersection(box, panel.bbox)
            outside = _area(box) - (_area(inside) if inside else 0.0)
            return outside + sum(_area(both) for other in taken if (both := Bbox.intersection(box, other)))

        best = min(PLACES, key=covered)
        covered(best)
        taken.append(Text.get_window_extent(label, renderer))


def _area(box: Any) -> float:
    return float(box.width * box.height)
