"""Progress of long calls: a bar in the terminal, or the caller's own function."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

ProgressCallback: TypeAlias = Callable[[float], object]
#: True shows a bar, a function is called with the share that is done (0 to 1), False does neither.
ProgressOption: TypeAlias = bool | ProgressCallback


@contextmanager
def reporting(progress: ProgressOption, what: str) -> Iterator[ProgressCallback | None]:
    """Turn the option into what the core calls; the bar goes away when the work is done."""
    if callable(progress):
        yield progress
        progress(1.0)
    elif progress:
        from rich.console import Console
        from rich.progress import Progress

        with Progress(console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(what, total=1.0)
            yield lambda done: bar.update(task, completed=done)
    else:
        yield None
