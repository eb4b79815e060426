"""A forest that does not fit: built and queried within memory that the system limits, beside trees in memory."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import fastlines as fl

from ..harness.figures import Figures
from ..harness.findings import Check
from . import streamlines
from .limited import run_limited
from .questions import QUESTIONS, RADIUS, columns_of, same

#: The fraction of the limit that is passed as `memory=`. The rest is for Python, its libraries and answers.
SHARE = 0.3

#: The rays of brute force on the whole scene.
BRUTE_RAYS = 32


def run_memory(n_segments: int, n_small: int, limit: int, n_rays: int, progress: Any) -> Figures:
    """Build and query a large scene and a small one within the limit; check the answers outside of it.

    The answers about the small scene are compared with those of one tree in memory, and those about the large one with
    brute force, for some rays.
    """
    rows: list[tuple[Any, ...]] = []
    n_wrong, peak = 0, 0
    for n in dict.fromkeys((n_small, n_segments)):
        with TemporaryDirectory(prefix="fastlines-bench-") as temporary:
            folder, answers = str(Path(temporary) / "forest"), str(Path(temporary) / "answers.npz")
            progress(f"memory: building {n:,} segments", 0.1)
            memory = int(SHARE * limit)
            built = run_limited(limit, action="build", folder=folder, n_segments=n, memory=memory, max_segments=None)
            progress(f"memory: querying {n:,} segments", 0.6)
            queried = run_limited(limit, action="query", folder=folder, memory=memory, n_rays=n_rays, answers=answers)
            rows.append((n, "build", built["n_tiles"], built["wall_s"], *_sizes(built), ""))
            progress(f"memory: checking {n:,} segments", 0.8)
            wrong, compared = (_beside_tree if n == n_small else _beside_brute_force)(folder, n, n_rays, answers)
            rows += [
                (n, name, built["n_tiles"], took, *_sizes(queried), compared.get(name, ""))
                for name, took in queried["seconds"].items()
            ]
            n_wrong += wrong
            peak = max(peak, built.get("VmPeak", 0), queried.get("VmPeak", 0))
    heads = ("segments", "what", "tiles", "seconds", "memory, MB", "addresses, MB", "compared with")
    notes = [
        f"The limit is {limit / 1e9:g} GB of addresses (RLIMIT_AS), {SHARE:.0%} of it passed as memory=; "
        f"{n_rays:,} rays or points, a sixteenth of them for all hits; radius {RADIUS:g}. Two threads or as many as "
        "the machine has. Memory is the peak of the process that ran all queries."
    ]
    checks = [
        Check("answers that differ", float(n_wrong), 0.0, scene="streamlines"),
        Check("GB of addresses at the peak", peak / 1e9, limit / 1e9, scene="streamlines"),
    ]
    return Figures("memory", "a forest within limited memory", heads, rows, notes, checks)


def _sizes(took: dict[str, Any]) -> tuple[float, float]:
    return took.get("VmHWM", 0) / 1e6, took.get("VmPeak", 0) / 1e6


def _beside_tree(folder: str, n: int, n_rays: int, answers: str) -> tuple[int, dict[str, str]]:
    """Compare all answers with those of one tree in memory."""
    tree = fl.build(streamlines.whole(n))
    n_wrong, compared = 0, {}
    with np.load(answers) as kept:
        for name, question in QUESTIONS.items():
            prefix = f"{name}/"
            found = {key.removeprefix(prefix): kept[key] for key in kept.files if key.startswith(prefix)}
            is_same = same(found, columns_of(question(tree, n_rays)))
            n_wrong += not is_same
            compared[name] = f"one tree: {'the same bits' if is_same else 'DIFFERENT'}"
    return n_wrong, compared


def _beside_brute_force(folder: str, n: int, n_rays: int, answers: str) -> tuple[int, dict[str, str]]:
    """Compare the answers for a few of the rays with brute force over all segments."""
    rows = np.linspace(0, n_rays - 1, BRUTE_RAYS).astype(np.int64)
    origins, directions = streamlines.rays(n_rays)
    first = fl.brute_force(streamlines.whole(n), origins[rows], directions[rows], RADIUS, query="first_hit")
    name = "first hits of random rays"
    with np.load(answers) as kept:
        columns = columns_of(first)
        found = {column: kept[f"{name}/{column}"][rows] for column in columns}
    is_same = same(found, columns)
    text = f"brute force, {BRUTE_RAYS} rays: {'the same bits' if is_same else 'DIFFERENT'}"
    return int(not is_same), {name: text}
