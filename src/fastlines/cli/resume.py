"""Pictures that Ctrl-C stops and ``--resume`` goes on with."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import typer

from ..errors import InputError
from ..progress import reporting
from ..rendering import Pace, Progressive, refined
from .files import check_output, note, show_progress

#: The least time between two unfinished pictures that are written.
WRITE_SECONDS = 3.0


def state_path(output: str) -> str:
    """Return the file beside a picture that has the samples so far."""
    return output + ".npz"


def check_resume(output: str, resume: bool) -> None:
    """Refuse, before any work, a state that cannot be written, or that is not there to go on with."""
    check_output(state_path(output))
    if resume and not Path(state_path(output)).is_file():
        raise InputError(f"{state_path(output)}: no such file; leave out --resume to render from the start")


def add_samples(renderer: Progressive, output: str, resume: bool, show: Callable[[], object] | None) -> bool:
    """Add samples until there are enough or until Ctrl-C; return whether all are there.

    `show` writes the picture so far. It is called every few seconds if the picture takes long.
    """
    if resume:
        renderer.resume(state_path(output))
    pace = Pace(WRITE_SECONDS)
    with reporting(show_progress(), "render") as callback:
        try:
            for _ in refined(renderer, callback, note):
                if show is not None and pace.show(renderer, show) and pace.n_shown == 1 and show_progress():
                    note(f"{output}: is a first picture; it is replaced by better ones as samples come")
        except KeyboardInterrupt:
            return False
    return True


@contextmanager
def without_interrupts() -> Iterator[None]:
    """Ignore Ctrl-C for a while, so that a second one does not lose what is being written."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def keep_state(renderer: Progressive, output: str, is_whole: bool, resumed: bool) -> None:
    """Delete the state of a whole picture that was resumed; write that of another, say so, and exit with 130."""
    state = state_path(output)
    if is_whole:
        if resumed:
            Path(state).unlink(missing_ok=True)
        return
    renderer.save(state)
    rows = f"{renderer.n_rows} of {renderer.height} rows of pixels"
    done = f"{renderer.done} of {renderer.samples} samples a pixel" if renderer.done else rows
    typer.echo(f"stopped after {done}; the same command with --resume goes on from {state}", err=True)
    raise typer.Exit(130)
