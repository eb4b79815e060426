"""Progress of long calls: a bar in the terminal or a notebook, or the caller's own function."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

from .errors import InputError

ProgressCallback: TypeAlias = Callable[[float], object]
#: True shows a bar; a function is called with the fraction that is done (0 to 1); False does neither.
ProgressOption: TypeAlias = bool | ProgressCallback


def check_progress(progress: object) -> None:
    """Refuse what neither switches the bar nor can be called: a text such as "no" would show one."""
    if not (isinstance(progress, bool) or callable(progress)):
        raise InputError(f"progress={progress!r}; expected True, False, or a function that takes the fraction done")


def staged(callback: ProgressCallback | None, begin: float, end: float) -> ProgressCallback | None:
    """Return a callback for a part of the work, from one fraction of the whole to another.

    Examples
    --------
    >>> second_half = staged(print, 0.5, 1)
    >>> second_half(0.5)
    0.75
    """
    return None if callback is None else lambda done: callback(begin + (end - begin) * done)


@contextmanager
def reporting(progress: ProgressOption, what: str) -> Iterator[ProgressCallback | None]:
    """Turn the option into the callback of the core; the bar disappears when the work is done."""
    check_progress(progress)
    if callable(progress):
        yield progress
        progress(1.0)
    elif progress:
        from rich.console import Console
        from rich.progress import Progress

        console = Console(stderr=True)
        if console.is_jupyter and importlib.util.find_spec("ipywidgets") is None:
            with _line(what) as show:  # in notebooks, rich's bar is a widget
                yield show
            return
        with Progress(console=console, transient=True) as bar:
            task = bar.add_task(what, total=1.0)
            yield lambda done: bar.update(task, completed=done)
    else:
        yield None


@contextmanager
def _line(what: str) -> Iterator[ProgressCallback]:
    """Show progress as one line of text, written over and over."""
    shown = -1

    def show(done: float) -> None:
        nonlocal shown
        percent = int(100 * done)
        if percent > shown:
            shown = percent
            print(f"\r{what} {percent:3} %", end="", file=sys.stderr, flush=True)

    show(0.0)
    try:
        yield show
    finally:
        print("\r" + " " * len(f"{what} 100 %"), end="\r", file=sys.stderr, flush=True)
