"""The memory that builds take: the peak of a process while it builds a tree and its layout.

Each build runs in a process of its own, which is fresh. The peak is that of the pages that the process has touched
(VmHWM of Linux), reset before each stage, less those before the build. Blocks that the core keeps for reuse count.
The ratio is the peak, the input included, over the tree and its input.
"""

from __future__ import annotations

import json
import multiprocessing
import re
import time
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl
from fastlines.settings.build_memory import build_bytes

#: The inputs: scenes of the thesis and streamlines, with their sizes.
INPUTS = (
    "straight-hair:1000000",
    "bun-hair:1000000",
    "spaghetti:100000",
    "spaghetti-2:100000",
    "photon-beams:100000",
    "streamlines:1000000",
    "straight-hair:4000000",
    "bun-hair:4000000",
    "streamlines:4000000",
)

#: The steps of a generated streamline.
STEPS = 50


def lines_of(text: str) -> fl.Lines:
    """Return the lines of NAME:SEGMENTS, where a name is that of a scene or "streamlines", or of a file."""
    name, _, n = text.rpartition(":")
    if not n.isdigit():
        opened = fl.read(text)
        if not isinstance(opened, fl.Lines):
            raise fl.InputError(f"{text} holds no lines; expected lines, or a scene such as {INPUTS[0]}")
        return opened
    return streamlines(int(n)) if name == "streamlines" else fl.scenes.make(name, int(n)).lines


def streamlines(n_segments: int) -> fl.Lines:
    """Return random walks that keep their direction, in a cube of 100, with segments of about 1."""
    random = np.random.default_rng(0)
    n = -(-n_segments // STEPS)
    begin, along = random.uniform(0, 100, (n, 1, 3)), random.normal(size=(n, 1, 3))
    steps = random.normal(0.0, 0.3, (n, STEPS, 3)) + along / np.linalg.norm(along, axis=2, keepdims=True)
    points = np.concatenate([begin, begin + np.cumsum(steps, axis=1)], axis=1).astype(np.float32)
    segments = np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3)[:n_segments]
    return fl.Lines(np.ascontiguousarray(segments), np.repeat(np.arange(n), STEPS)[:n_segments])


def status(name: str) -> int:
    """Return a field of the process's status, in bytes."""
    found = re.search(rf"^{name}:\s+(\d+)", Path("/proc/self/status").read_text(encoding="ascii"), re.MULTILINE)
    return 1024 * int(found[1]) if found else 0


def reset_peak() -> int:
    """Forget the peak of the process's memory; return its memory now."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    return status("VmRSS")


def measure(path: str, name: str, n_threads: int) -> dict[str, Any]:
    """Build a tree over the lines in a file and its layout; return sizes, peaks and times."""
    fl.set_num_threads(n_threads)
    with np.load(path) as arrays:
        lines = fl.Lines(arrays["segments"], arrays["strands"])
    fl.build(lines.segments[:10])
    held = lines.segments.nbytes + lines.strands.nbytes
    before, start = reset_peak(), time.perf_counter()
    tree = fl.build(lines)
    seconds, peak, after = time.perf_counter() - start, status("VmHWM") - before, status("VmRSS") - before
    made = tree.nodes.nbytes + tree.refs.nbytes
    reset_peak()
    layout = tree.layout
    return {
        "lines": name,
        "threads": n_threads,
        "seconds": round(seconds, 2),
        "n_refs": tree.n_refs,
        "input_bytes": held,
        "tree_bytes": made,
        "peak_bytes": peak,
        "kept_bytes": after - made,
        "expected_bytes": build_bytes(len(lines), tree.settings, tree.n_refs, n_threads),
        "layout_bytes": layout.nodes.nbytes + layout.leaves.nbytes + layout.refs.nbytes,
        "with_layout_peak_bytes": status("VmHWM") - before,
        "ratio": round((held + peak) / (held + made), 3),
    }


def print_memory(inputs: list[str], threads: list[int], folder: Path) -> None:
    """Print a line of JSON for each build."""
    context = multiprocessing.get_context("spawn")
    for text in inputs or INPUTS:
        lines = lines_of(text)
        np.savez(folder / "lines.npz", segments=lines.segments, strands=lines.strands)
        del lines
        for n_threads in threads:
            with context.Pool(1) as pool:
                print(json.dumps(pool.apply(measure, (str(folder / "lines.npz"), text, n_threads))), flush=True)
