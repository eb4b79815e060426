"""The primitives behind boxes and planes, and the limits of the axes around them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .axes import INK, library, width_of
from .projection import Projection
from .subject import Subject

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Up to so many primitives are few. The width of strokes in points, for few primitives and for many.
FEW, FEW_WIDTH, MANY_WIDTH = 63, 1.4, 0.3
#: How much of the picture many strokes would cover side by side, and how opaque they can be. So dense lines show boxes.
COVERED, OPACITY = 0.5, (0.04, 0.6)
#: From this number of primitives on, they are pixels in a vector file. So the file stays small.
PIXELS_FROM = 1_000
#: How far axes reach beyond what is drawn, as a fraction of its longest side.
MARGIN = 0.04


def draw_backdrop(ax: Axes, subject: Subject, view: Projection) -> None:
    """Draw the primitives of a tree, the finer the more there are, and fit the axes to them and to the root's box."""
    # The boxes of trees hold the axes of thick lines, and not all of their surfaces.
    extents = [view.points(part).reshape(-1, 2) for part in (subject.boxes[0], *subject.strokes)]
    low = np.min([points.min(axis=0) for points in extents], axis=0)
    high = np.max([points.max(axis=0) for points in extents], axis=0)
    longest = float((high - low).max())
    is_few = subject.n_drawn <= FEW
    width = FEW_WIDTH if is_few else MANY_WIDTH
    # The area of a stroke is that of a pen as wide, in squares of the longest side.
    pen = width / 72 / max(width_of(ax), 0.5)
    collection = library("matplotlib.collections").LineCollection
    for part in subject.strokes:
        strokes = view.points(part if part.shape[1] == 2 else np.concatenate([part, part[:, :1]], axis=1))
        length = float(np.linalg.norm(np.diff(strokes, axis=1), axis=2).sum()) / (longest or 1.0)
        opacity = 1.0 if is_few else float(np.clip(COVERED / max(pen * length, COVERED), *OPACITY))
        drawn = collection(list(strokes), colors=INK, linewidths=width, alpha=opacity, zorder=1)
        drawn.set_rasterized(subject.n_drawn >= PIXELS_FROM)
        ax.add_collection(drawn, autolim=False)
    margin = MARGIN * longest or 1.0
    ax.set_aspect("equal")
    ax.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    ax.set_ylabel(view.names[1])
    ax.ticklabel_format(useOffset=False)
    ax.locator_params(nbins=4)
