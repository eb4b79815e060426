"""The axes of drawings: figures without pyplot, and colours that print well.

A figure that is made here is light, also in a dark notebook. Axes of the caller's are light inside, and texts around
them keep the caller's style. No function opens a window or keeps a figure alive.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..errors import InputError
from ..support.optional import optional

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Texts and edges, the lines of a scene, and what is behind everything.
INK, FAINT, PAPER = "#222222", "#9aa0a8", "#ffffff"
#: Colours that colour-blind readers tell apart (Okabe and Ito 2008), without the yellow, which is pale on paper.
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
#: Inner nodes and leaves.
INNER, LEAF = COLORS[0], COLORS[1]
#: Ordered things have colours from this part of viridis: its bright end is pale on paper, more so on a projector.
ORDERED, BRIGHTEST = "viridis", 0.65
#: How many characters of a note fit into an inch.
CHARACTERS = 16
#: The pixels an inch, of pictures and of what is pixels in a vector file.
DPI = 150
#: The size of texts in points.
TEXT, SMALL = 9.0, 7.5

_LIGHT = {
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": INK,
    "axes.facecolor": PAPER,
    "axes.linewidth": 0.6,
    "axes.titlesize": TEXT + 1,
    "axes.labelsize": TEXT - 0.5,
    "figure.facecolor": PAPER,
    "figure.titlesize": TEXT + 2,
    "font.family": ["sans-serif"],
    "font.size": TEXT,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
}


def library(name: str = "matplotlib") -> Any:
    """Import matplotlib, or a module of it."""
    return optional(name, "a drawing of a tree", "plot")


def light() -> Any:
    """Return a context in which new figures and axes are light."""
    return library().rc_context(_LIGHT)


def new_figure(width: float, height: float) -> Figure:
    """Return a light figure of some inches that pyplot does not know; make its axes within `light`."""
    with light():
        figure: Figure = library("matplotlib.figure").Figure(figsize=(width, height), layout="constrained", dpi=DPI)
    return figure


def axes_of(ax: Axes | None, width: float = 5.0, height: float = 5.0) -> Axes:
    """Return the axes to draw on, new ones if none are given.

    Raises
    ------
    InputError
        If `ax` is not axes of matplotlib.
    """
    if ax is None:
        with light():
            made: Axes = new_figure(width, height).subplots()
        return made
    kind: type[Axes] = library("matplotlib.axes").Axes
    if not isinstance(ax, kind):
        raise InputError(f"ax is {type(ax).__name__}; expected Axes of matplotlib, as plt.subplots makes them, or None")
    ax.set_facecolor(PAPER)
    return ax


def describe(ax: Axes, title: str, notes: Sequence[str] = (), below: str = "") -> None:
    """Write what is seen above the axes; below them, what is on the horizontal axis, and notes."""
    ax.set_title(title)
    caption = textwrap.fill("; ".join(notes), max(30, int(width_of(ax) * CHARACTERS)))
    ax.set_xlabel("\n".join(filter(None, [below, caption])))


def legend(ax: Axes, corner: Literal["upper right", "lower right"], width: float | None = None) -> int:
    """Draw a light legend in a corner; return its rows. With the width of an entry in inches, rows have several."""
    n_entries = len(ax.get_legend_handles_labels()[0])
    if n_entries == 0:
        return 0
    columns = 1 if width is None else max(1, min(n_entries, int(width_of(ax) / width)))
    ax.legend(loc=corner, ncols=columns, fontsize="small", labelcolor=INK, facecolor=PAPER, framealpha=0.9)
    return -(-n_entries // columns)


def width_of(ax: Axes) -> float:
    """Return about how wide axes are, in inches."""
    return float(ax.get_window_extent().width) / ax.figure.dpi


def without_frame(ax: Axes) -> None:
    """Hide ticks and frame, but not the texts around them."""
    ax.set(xticks=[], yticks=[])
    for spine in ax.spines.values():
        spine.set_visible(False)


def share_width(panels: Sequence[Axes]) -> None:
    """Let the horizontal axes of several panels end where the longest one does."""
    longest = max(panel.get_xlim()[1] for panel in panels)
    for panel in panels:
        panel.set_xlim(0, longest)


def share_scale(panels: Sequence[Axes]) -> None:
    """Give the images of several axes the scale of the brightest one."""
    images = [image for panel in panels for image in panel.images]
    for image in images:
        image.set_clim(0, max(other.get_clim()[1] for other in images))


def ordered_colors(count: int) -> Any:
    """Return (count, 4) colours from dark to bright."""
    return library().colormaps[ORDERED](np.linspace(0, BRIGHTEST, max(count, 1)))
