"""A process that builds or queries a forest within a limit of addresses, which the system enforces (``RLIMIT_AS``).

Run as ``python -m fastlines_bench.scale.limited JOB.json``; it prints what it took as JSON.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

try:
    import resource
except ImportError:  # not on Windows
    resource = None  # type: ignore[assignment]


def run_limited(limit: int | None, **job: Any) -> dict[str, Any]:
    """Do a job in a process of its own within so many bytes, and return what it took.

    Raises
    ------
    RuntimeError
        If the process fails; the text is what it wrote.
    """
    command = [sys.executable, "-m", __name__, json.dumps({"limit": limit, **job})]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{job['action']} within {limit} bytes: {done.stderr.strip()[-2000:] or done.returncode}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def build(folder: str, n_segments: int, memory: int | None, max_segments: int | None, seed: int = 0) -> dict[str, Any]:
    """Build a forest of generated streamlines."""
    import fastlines as fl

    from .streamlines import chunks

    forest = fl.build_forest(chunks(n_segments, seed), folder, memory=memory, max_segments=max_segments)
    size = sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())
    return {"n_tiles": forest.n_tiles, "folder_bytes": size}


def query(folder: str, memory: int | None, n_rays: int, answers: str) -> dict[str, Any]:
    """Query a forest, and write the answers to a file."""
    import numpy as np

    import fastlines as fl

    from .questions import QUESTIONS, columns_of

    forest = fl.Forest(folder, memory=memory)
    seconds: dict[str, float] = {}
    kept: dict[str, Any] = {}
    for name, question in QUESTIONS.items():
        begin = time.perf_counter()
        found = question(forest, n_rays)
        seconds[name] = time.perf_counter() - begin
        kept |= {f"{name}/{column}": values for column, values in columns_of(found).items()}
    np.savez(answers, **kept)
    return {"seconds": seconds}


def main(text: str) -> None:
    """Do the job that a text in JSON describes, and print what it took."""
    job = json.loads(text)
    limit = job.pop("limit")
    if limit is not None:
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    actions: dict[str, Callable[..., dict[str, Any]]] = {"build": build, "query": query}
    begin = time.perf_counter()
    found = actions[job.pop("action")](**job)
    took = {"wall_s": time.perf_counter() - begin, "cpu_s": time.process_time()}
    print(json.dumps({**found, **took, **_peaks()}))


def _peaks() -> dict[str, int]:
    """Return the most bytes of memory and of addresses that this process has had."""
    status = Path("/proc/self/status")
    text = status.read_text(encoding="ascii") if status.exists() else ""
    found = {name: re.search(rf"^{name}:\s+(\d+) kB", text, re.MULTILINE) for name in ("VmHWM", "VmPeak")}
    return {name: 1024 * int(match[1]) for name, match in found.items() if match}


if __name__ == "__main__":
    main(sys.argv[1])
