"""A build that is killed at random moments and started again: the same forest, byte for byte."""

from __future__ import annotations

import json
import subprocess
import sys
import time
import zlib
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ..harness.figures import Figures
from ..harness.findings import Check


def run_restarts(n_segments: int, n_tiles: int, n_kills: int, progress: Any) -> Figures:
    """Kill a build so often, each time after a random part of the time that an undisturbed one takes."""
    from .answers import most_segments

    rng = np.random.default_rng(34)
    job = {
        "action": "build",
        "n_segments": n_segments,
        "memory": None,
        "max_segments": most_segments(n_segments, n_tiles),
    }
    with TemporaryDirectory(prefix="fastlines-bench-") as temporary:
        whole, killed = Path(temporary) / "whole", Path(temporary) / "killed"
        begin = time.perf_counter()
        _started(job, whole).wait()
        alone = time.perf_counter() - begin
        expected = _sums(whole)
        moments: list[float] = []
        n_starts = 0
        begin = time.perf_counter()
        while len(moments) < n_kills:
            # A build that has come far ends before it is killed: begin anew, so that kills hit all stages.
            n_starts += 1
            progress(f"restarts: kill {len(moments) + 1} of {n_kills}", len(moments) / n_kills)
            process = _started(job, killed)
            after = float(rng.uniform(0.02, 0.6)) * alone
            try:
                process.wait(timeout=after)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                moments.append(after / alone)
            else:
                if _sums(killed) != expected:
                    break
                _remove(killed)
        _started(job, killed).wait()
        took = time.perf_counter() - begin
        is_same = bool(expected) and _sums(killed) == expected
    heads = ("segments", "tiles", "kills", "starts", "alone, s", "all runs, s", "the same bytes")
    rows = [(n_segments, n_tiles, len(moments), n_starts + 1, alone, took, "yes" if is_same else "NO")]
    notes = ["Each run is ended by SIGKILL after a random 2 % to 60 % of the time of an undisturbed build."]
    checks = [Check("forests that differ after kills", float(not is_same), 0.0, scene="streamlines")]
    return Figures("restarts", "a build that is killed and started again", heads, rows, notes, checks)


def _started(job: dict[str, Any], folder: Path) -> subprocess.Popen[bytes]:
    command = [
        sys.executable,
        "-m",
        "fastlines_bench.scale.limited",
        json.dumps({"limit": None, "folder": str(folder), **job}),
    ]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL)


def _sums(folder: Path) -> dict[str, int]:
    """Return a checksum of each file of a folder."""
    return {
        path.relative_to(folder).as_posix(): zlib.crc32(path.read_bytes())
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def _remove(folder: Path) -> None:
    import shutil

    shutil.rmtree(folder)
