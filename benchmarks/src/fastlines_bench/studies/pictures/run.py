"""Times pictures as their user sees them: ``fastlines render`` in a process of its own, from start to end."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ...harness import machine
from ...harness.internals import FastlinesError
from ...harness.preset import Preset, sized
from ...peers import pyvista_tubes
from .cases import Case, dense_head

#: How often a folder is searched for a picture, in seconds.
LOOK = 0.01


@dataclass(frozen=True, kw_only=True)
class PicturesPreset(Preset):
    """How pictures are timed.

    Parameters
    ----------
    n_threads : int
    rounds : int
        How often each picture is made; medians count.
    peer : bool
        Whether PyVista's tubes are timed beside ours.
    data : str, optional
        The folder of the files.
    dense : bool
        Whether a dense head of hair is timed too.
    n_strands, size, samples : int
        Those of the dense head: its width and height in pixels, and the samples of each.
    """

    n_threads: int = 2
    rounds: int = sized(3, 1)
    peer: bool = True
    data: str | None = None
    dense: bool = False
    n_strands: int = sized(1_000_000, 2_000)
    size: int = sized(1024, 64)
    samples: int = sized(64, 2)


@dataclass(frozen=True)
class PictureTimes:
    """The seconds of a picture in a process of its own.

    Attributes
    ----------
    cpu, seconds : float
        Of the processor and of the clock, from the start of the process to its end.
    first : float
        Of the clock, until the first picture is there.
    """

    cpu: float
    seconds: float
    first: float


@dataclass(frozen=True)
class PicturesCell:
    """One picture, and how long it takes; `peer` is PyVista's, or None, and `why` says why."""

    name: str
    options: tuple[str, ...]
    ours: PictureTimes
    peer: PictureTimes | None
    why: str


@dataclass(frozen=True)
class PicturesResult:
    """All pictures, and those of which the files are missing."""

    machine: dict[str, Any]
    preset: PicturesPreset
    cells: list[PicturesCell]
    missing: list[str]

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {"format": "fastlines-bench pictures 1", **asdict(self)}


def run_pictures(
    cases: Sequence[Case],
    missing: Sequence[Case],
    preset: PicturesPreset,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> PicturesResult:
    """Make each picture several times.

    Parameters
    ----------
    cases, missing : sequence of Case
        Those that are timed, and those without a file.
    preset : PicturesPreset
    progress : callable
        Called with the current work and the share of all work that is done.
    """
    cells = []
    with tempfile.TemporaryDirectory() as folder:
        several = list(cases)
        if preset.dense:
            progress("the tree of the dense hair", 0.0)
            several.append(dense_head(Path(folder), preset.data, preset.n_strands, preset.size, preset.samples))
        for i, case in enumerate(several):
            progress(case.name, i / len(several))
            is_dense = i == len(cases)
            cells.append(_cell(case, preset, Path(folder), "light is traced in it" if is_dense else ""))
    return PicturesResult(machine.describe(), preset, cells, [case.name for case in missing])


def _cell(case: Case, preset: PicturesPreset, folder: Path, why: str) -> PicturesCell:
    """Time a picture, and PyVista's tubes in turn unless something says why not."""
    why = why or ("" if preset.peer else "not asked for") or pyvista_tubes.missing()
    picture = folder / "ours.png"
    render = [sys.executable, "-m", "fastlines", "render", case.source, "-o", str(picture), *case.options]
    tubes = folder / "theirs.png"
    peer = [sys.executable, "-m", pyvista_tubes.__name__, case.source, str(tubes)]
    ours, theirs = [], []
    for _ in range(preset.rounds):
        ours.append(timed_process(render, picture, preset.n_threads))
        if not why:
            try:
                theirs.append(timed_process(peer, tubes, preset.n_threads))
            except FastlinesError as error:
                why = str(error)
    return PicturesCell(case.name, case.options, _medians(ours), _medians(theirs) if theirs else None, why)


def timed_process(command: Sequence[str], picture: Path, n_threads: int) -> PictureTimes:
    """Run a command that makes a picture, and watch the file appear.

    Raises
    ------
    FastlinesError
        If the command fails, or makes no picture.
    """
    picture.unlink(missing_ok=True)
    environment = {**os.environ, "FASTLINES_NUM_THREADS": str(n_threads)}
    with tempfile.TemporaryFile() as said:
        before, start = os.times(), time.perf_counter()
        first = None
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said, env=environment) as process:
            while process.poll() is None:
                if first is None and picture.exists():
                    first = time.perf_counter() - start
                time.sleep(LOOK)
        seconds, after = time.perf_counter() - start, os.times()
        said.seek(0)
        words = said.read().decode(errors="replace").strip().splitlines()
    if process.returncode or not picture.exists():
        raise FastlinesError(words[-1] if words else f"the command ended with exit code {process.returncode}")
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return PictureTimes(cpu, seconds, seconds if first is None else first)


def _medians(rounds: Sequence[PictureTimes]) -> PictureTimes:
    columns = zip(*((each.cpu, each.seconds, each.first) for each in rounds), strict=True)
    return PictureTimes(*map(statistics.median, columns))
