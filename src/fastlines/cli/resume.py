"""Pictures that Ctrl-C stops and ``--resume`` goes on with."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

import typer

from ..errors import InputError
from ..progress import reporting
from ..rendering import Pace, Progressive, refined
from .files import check_output, note, show_progress

#: The least time between two unfinished pictures that are written.
WRITE_SECONDS = 3.0


class Resumable(Protocol):
    """A picture that can be saved before it is whole."""

    def save(self, path: str) -> None:
        """Write all that is done to a file; it appears whole or not at all."""


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
                is_shown = show is not None and pace.show(renderer.seconds_left, show)
                if is_shown and pace.n_shown == 1 and show_progress():
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


def keep_state(picture: Resumable, output: str, is_whole: bool, is_ours: bool, done: str) -> None:
    """Delete the state of a whole picture; write that of another, say so, and exit with 130.

    Parameters
    ----------
    picture : Resumable
    output : str
        The file of the picture.
    is_whole : bool
    is_ours : bool
        Whether this command has read or written the state before, so that it may delete it.
    done : str
        How much of the picture is done, in words.
    """
    state = state_path(output)
    if is_whole:
        if is_ours:
            Path(state).unlink(missing_ok=True)
        return
    picture.save(state)
    typer.echo(f"stopped after {done}; the same command with --resume goes on from {state}", err=True)
    raise typer.Exit(130)
