"""The runs: for each operation and each way to fail, a process that tries all of its calls in turn."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path

from .library import compile_library, compile_program

#: Ways in which the calls of an operation fail, by what fails.
MODES = {
    "memory": ("once", "ever", "threads"),
    "library": ("once", "ever", "threads"),
    "files": ("ENOSPC", "EIO", "EINTR"),
    "reads": ("EIO", "EINTR", "short"),
}
#: The library for LD_PRELOAD that makes them fail.
PRELOADED = {"memory": "memory", "library": "memory", "files": "files", "reads": "files"}

#: Deaths of a process after which an operation is given up, and seconds that all of its runs may take.
MAX_DEATHS, MAX_SECONDS = 8, 1200


@dataclass
class Row:
    """An operation, a way to fail, how many calls failed in turn, and each n whose failure was not handled."""

    operation: str
    mode: str
    n_calls: int = 0
    wrong: list[str] = field(default_factory=list)
    leaked: float = 0.0
    calls: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Compiled:
    """What is compiled for a run: the libraries for LD_PRELOAD, and the program with the library for C++ and C."""

    libraries: dict[str, Path]
    program: Path | None

    def command(self, what: str) -> list[str]:
        """Return the command that runs an operation, but for its arguments."""
        if what == "library":
            return [str(self.program)]
        return [sys.executable, "-m", f"{__package__}.{what}_worker"]


def names(what: str, compiled: Compiled) -> list[str]:
    """Return the names of all operations."""
    with tempfile.TemporaryDirectory() as folder:
        if what == "library":
            command = [*compiled.command(what), folder]
            return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
        if what == "reads":
            from .read_operations import ReadOperations

            return [operation.name for operation in ReadOperations(Path(folder))]
        if what == "memory":
            from .memory_operations import Operations

            return [operation.name for operation in Operations(Path(folder))]
        from .file_operations import FileOperations

        return [operation.name for operation in FileOperations(Path(folder))]


def run_operation(what: str, compiled: Compiled, name: str, mode: str) -> Row:
    """Fail each call of an operation in turn; if its process dies, go on after that call in a new one."""
    row, first, n_deaths = Row(name, mode), 1, 0
    while n_deaths < MAX_DEATHS:
        with tempfile.TemporaryDirectory() as folder:
            command = [*compiled.command(what), name, mode, str(first), folder]
            environment = {**os.environ, "LD_PRELOAD": str(compiled.libraries[PRELOADED[what]])}
            process = subprocess.Popen(
                command, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
            )
            try:
                output, errors = process.communicate(timeout=MAX_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                output, errors = process.communicate()
                errors = f"{errors}\nhangs"
        told = [json.loads(line) for line in output.splitlines() if line.startswith("{")]
        at = max((each["trying"] for each in told if "trying" in each), default=first)
        row.wrong += [f"{each['n']}: {each['wrong']}" for each in told if "wrong" in each]
        for each in told:
            if "call" in each:
                row.calls[each["call"]] = row.calls.get(each["call"], 0) + 1
        if told and "n_calls" in told[-1]:
            row.n_calls, row.leaked = told[-1]["n_calls"], told[-1].get("leaked", 0.0)
            return row
        last = (errors.strip().splitlines() or [""])[-1]
        row.wrong.append(f"{at}: the process ends with {process.returncode}: {last}")
        n_deaths, first = n_deaths + 1, at + 1
    row.n_calls = first - 1
    row.wrong.append(f"given up after {MAX_DEATHS} ends of its process")
    return row


def run_faults(whats: Iterable[str], text: str | None, progress: Callable[[str, float], None]) -> dict[str, list[Row]]:
    """Fail the calls of all operations, or of those whose name contains a text, in all ways."""
    with tempfile.TemporaryDirectory() as folder:
        rows: dict[str, list[Row]] = {what: [] for what in whats}
        libraries = {what: compile_library(what, Path(folder)) for what in {PRELOADED[what] for what in rows}}
        compiled = Compiled(libraries, compile_program(Path(folder)) if "library" in rows else None)
        tries = [(w, name, m) for w in rows for name in names(w, compiled) if (text or "") in name for m in MODES[w]]
        for i, (what, name, mode) in enumerate(tries):
            progress(f"{name}, {mode}", i / len(tries))
            rows[what].append(run_operation(what, compiled, name, mode))
    return rows


def to_json(rows: dict[str, list[Row]]) -> dict[str, object]:
    """Return all rows as JSON."""
    return {"format": "fastlines-bench faults 1", **{what: [asdict(row) for row in of] for what, of in rows.items()}}
