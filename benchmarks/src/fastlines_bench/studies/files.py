"""The time and the memory in which fastlines, and the libraries of their formats, read files of streamlines."""

from __future__ import annotations

import importlib.util
import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl

from ..harness import machine
from ..harness.internals import FastlinesError
from ..harness.preset import Preset, sized
from ..harness.tables import format_3_digits, new_table, print_table, wide_console
from . import file_reader

#: The other readers of each format. The first is the one to which fastlines is compared.
PEERS = {
    ".trk": ("nibabel", "nibabel, as lines"),
    ".tck": ("nibabel", "nibabel, as lines"),
    ".trx": ("trx-python", "trx-python, as lines"),
    ".usdc": ("usd-core", "usd-core, as lines"),
}
#: The voxel grid around the streamlines, for the formats that have one.
GRID = {"voxel_to_rasmm": np.eye(4), "dimensions": (201, 201, 201)}


@dataclass(frozen=True, kw_only=True)
class FilesPreset(Preset):
    """Which files are read.

    Parameters
    ----------
    n_segments : int
        The number of segments in each file.
    per_strand : int
        The mean number of segments of a streamline.
    rounds : int
        How often each reader reads each file; medians count.
    formats : tuple of str
        Keys of `PEERS`. Formats that fastlines does not write are left out.
    """

    n_segments: int = sized(10_000_000, 100_000)
    per_strand: int = 50
    rounds: int = sized(3, 1)
    formats: tuple[str, ...] = tuple(PEERS)


@dataclass(frozen=True)
class FilesCell:
    """One reader of one file.

    Attributes
    ----------
    seconds, cpu : float
        Seconds of the clock and of the processor.
    bytes : int
        The memory that the reader needs at its peak, the answer included.
    """

    extension: str
    file_bytes: int
    reader: str
    seconds: float
    cpu: float
    bytes: int


@dataclass(frozen=True)
class FilesResult:
    """All readers of all files."""

    machine: dict[str, Any]
    preset: FilesPreset
    cells: list[FilesCell]

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {"format": "fastlines-bench files 1", **asdict(self)}


def streamlines(n_segments: int, per_strand: int) -> fl.Lines:
    """Return random walks of half a millimetre a step, of half to one and a half times the mean length."""
    rng = np.random.default_rng(0)
    counts = rng.integers(per_strand // 2, per_strand * 3 // 2 + 1, size=max(1, n_segments // max(per_strand, 1)))
    counts[-1] += max(0, n_segments - int(counts.sum()))
    steps = rng.normal(scale=0.3, size=(int(counts.sum()) + len(counts), 3)).astype(np.float32)
    lines = fl.Lines.from_points(np.cumsum(steps, axis=0, dtype=np.float32) % 200, counts + 1)
    return replace(lines, unit="mm", up="z")


def run_files(preset: FilesPreset, progress: Callable[[str, float], None] = lambda what, share: None) -> FilesResult:
    """Write a file in each format; let each reader read it in a process of its own.

    Parameters
    ----------
    preset : FilesPreset
    progress : callable
        Called with the current work and the share of all work that is done.
    """
    cells: list[FilesCell] = []
    known = [extension for extension in preset.formats if _is_written(extension)]
    with tempfile.TemporaryDirectory() as folder:
        for i, extension in enumerate(known):
            progress(f"{extension}: writing", i / len(known))
            small, path = (Path(folder) / f"{name}{extension}" for name in ("small", "streamlines"))
            options: dict[str, Any] = {"reference": GRID} if extension in (".trk", ".trx") else {}
            fl.write(small, streamlines(10, 5), **options)
            fl.write(path, streamlines(preset.n_segments, preset.per_strand), **options)
            readers = [name for name in ("fastlines", *PEERS[extension]) if _is_there(name)]
            figures: dict[str, list[dict[str, float]]] = {name: [] for name in readers}
            for _ in range(preset.rounds):
                for name in readers:
                    progress(f"{extension}: {name}", i / len(known))
                    figures[name].append(_read(name, small, path))
            for name, rounds in figures.items():
                medians = {key: statistics.median(each[key] for each in rounds) for key in rounds[0]}
                size = path.stat().st_size
                cells.append(
                    FilesCell(extension, size, name, medians["seconds"], medians["cpu"], int(medians["bytes"]))
                )
            path.unlink()
    return FilesResult(machine.describe(), preset, cells)


def _is_written(extension: str) -> bool:
    known = fl.io.known_formats()
    return bool(extension in known and known[extension].writes)


def _is_there(reader: str) -> bool:
    """Return whether the libraries of a reader are installed."""
    modules, _ = file_reader.READERS[reader]
    return all(importlib.util.find_spec(module.split(".")[0]) is not None for module in modules)


def _read(reader: str, small: Path, path: Path) -> dict[str, float]:
    """Read a file in a new process; return its figures."""
    command = [sys.executable, "-P", file_reader.__file__, reader, str(small), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        said = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise FastlinesError(f"{reader} could not read {path.name}: {said[-1]}")
    figures: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return figures


def print_files(result: FilesResult) -> None:
    """Print a row for each reader of each file, and how it compares with fastlines."""
    console = wide_console()
    preset = result.preset
    title = f"reading {preset.n_segments:,} segments, {preset.per_strand} a streamline"
    figures = ["seconds", "CPU seconds", "MB", "B per segment", "seconds / ours", "MB / ours"]
    table = new_table(title, ["file", "reader"], figures)
    for cell in result.cells:
        ours = next(each for each in result.cells if each.extension == cell.extension)
        table.add_row(
            cell.extension,
            cell.reader,
            *(format_3_digits(each) for each in (cell.seconds, cell.cpu, cell.bytes / 1e6)),
            f"{cell.bytes / preset.n_segments:.0f}",
            f"{cell.seconds / max(ours.seconds, 1e-9):.2f}",
            f"{cell.bytes / max(ours.bytes, 1):.2f}",
        )
    print_table(console, table)
    console.print(
        f"Medians of {preset.rounds} round(s), each in a new process, without the time and the memory of imports. "
        "MB: the peak. fastlines returns both ends and the strand of each segment, 32 bytes. The libraries return "
        "points, 12 bytes each, or maps of the file; 'as lines' makes of them what fastlines returns.",
        highlight=False,
    )
