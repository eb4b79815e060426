"""How a picture is made while someone waits: a draft if it is large, how long it takes, and sample after sample."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from ..progress import ProgressCallback
from ..support.texts import duration_text
from .progressive import Progressive

#: A picture of this many pixels begins with a draft.
LARGE = 1 << 16
#: A picture that takes more seconds says how many before it starts.
LONG = 60.0
#: A picture is shown unfinished if the rest takes more seconds.
WAITED = 2.0
#: Showing unfinished pictures takes this fraction of the time at most.
SHARE = 0.1


def refined(renderer: Progressive, progress: ProgressCallback | None, say: Callable[[str], object]) -> Iterator[None]:
    """Add all samples, and yield whenever there is a better picture to show.

    Parameters
    ----------
    renderer : Progressive
    progress : callable, optional
        Called with the fraction of the samples that is done.
    say : callable
        Called with a sentence that says how long the samples take, if that is more than a minute.
    """
    is_reported = False
    if renderer.done == 0 and renderer.width * renderer.height >= LARGE:
        renderer.draw_draft()
        report_if_long("this picture takes", renderer.seconds_left, say)
        is_reported = True
        yield
    for _ in renderer.passes(progress):
        if not is_reported and renderer.seconds_left is not None:
            report_if_long("this picture takes", renderer.seconds_left, say)
            is_reported = True
        yield


def report_if_long(what: str, seconds: float | None, say: Callable[[str], object]) -> None:
    """Say how long something takes, if that is known, and more than a minute.

    Examples
    --------
    >>> report_if_long("this picture takes", 59.0, print)
    >>> report_if_long("this picture takes", 200.0, print)
    this picture takes about 3 minutes
    """
    if seconds is not None and seconds > LONG:
        say(f"{what} about {duration_text(seconds)}")


@dataclass
class Pace:
    """When an unfinished picture is shown: the first one at once, and others after some seconds.

    Attributes
    ----------
    seconds : float
        The least time between two pictures.
    """

    seconds: float
    n_shown: int = field(default=0, init=False)
    _next: float = field(default=0.0, init=False)

    def show(self, seconds_left: float | None, draw: Callable[[], object]) -> bool:
        """Call a function that shows the picture so far, if that is due; return whether it was called."""
        start = time.perf_counter()
        if start < self._next or (seconds_left is not None and seconds_left < WAITED):
            return False
        draw()
        end = time.perf_counter()
        self.n_shown += 1
        self._next = end + max(self.seconds, (end - start) / SHARE)
        return True
