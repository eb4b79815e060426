"""A picture of the benchmark: rates of both sides in each cell."""

from __future__ import annotations

import math
import os

from ..errors import MissingExtraError
from .labels import label_log
from .result import Result, geometric_mean


def check() -> None:
    """Refuse, before the work is done, to draw without matplotlib."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise MissingExtraError("A plot", "bench") from None


def draw(result: Result, path: str | os.PathLike[str]) -> None:
    """Draw points, a panel for each kind of rays and query, and write them as a PNG."""
    check()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    groups = result.groups()
    n_cells = max(len(cells) for cells in groups.values())
    figure = Figure(figsize=(max(6.0, 0.6 * n_cells + 2), 2.6 * len(groups)), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(groups), 1, squeeze=False)[:, 0]
    for panel, ((kind, query), cells) in zip(panels, groups.items(), strict=True):
        places = list(range(len(cells)))
        ours, theirs = [cell.mrays for cell in cells], [cell.best.mrays if cell.best else math.nan for cell in cells]
        panel.vlines(places, ours, theirs, color="#cbd5e1", zorder=0)
        panel.plot(places, ours, "o", label="fastlines", color="#c2410c")
        if any(cell.best for cell in cells):
            panel.plot(places, theirs, "s", label="Embree, its best", color="#64748b")
        mean = geometric_mean([cell.ratio for cell in cells])
        panel.set_title(
            f"{kind} rays, {query}" + (f": {mean:.2f} × Embree (geometric mean)" if mean else ""), loc="left"
        )
        panel.set_yscale("log")
        label_log(panel.yaxis)
        panel.set_ylabel("Mrays/s")
        panel.set_xlim(-0.5, len(cells) - 0.5)
        panel.set_xticks(places, [f"{cell.scene}\n{cell.radius:g}" for cell in cells], fontsize=6)
        panel.spines[["top", "right"]].set_visible(False)
    panels[0].legend(loc="upper right", frameon=False)
    figure.savefig(path, dpi=120, format="png")
