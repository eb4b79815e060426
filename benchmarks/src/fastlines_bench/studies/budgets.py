"""The effect of limits on references or memory on a build: its time, its memory, and the cost of the tree.

Each build runs in its own process. Memory is the peak of the resident memory less that before the build. Costs have
c_trav = 2.
"""

from __future__ import annotations

import json
import multiprocessing
import threading
import time
from pathlib import Path
from typing import Any

import fastlines as fl

SPAGHETTI = "spaghetti:100000"
BUDGETS: list[dict[str, float]] = [
    {"max_refs": 16_000_000},
    {"max_refs": 8_000_000},
    {"max_refs": 4_000_000},
    {"max_refs": 2_000_000},
    {"max_refs": 1_000_000},
    {"max_refs": 300_000},
    {"max_bytes": 500_000_000},
]


def resident() -> int:
    """Return the resident memory of this process in bytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def measure(scene: str, given: dict[str, float]) -> dict[str, Any]:
    """Build within limits, and return the time, the memory and the cost."""
    limits = {name: int(value) for name, value in given.items() if name != "c_trav"}
    cost = fl.Cost(given["c_trav"]) if "c_trav" in given else None
    name, _, n = scene.partition(":")
    lines = fl.scenes.make(name, int(n) if n else None).lines
    before = most = resident()
    done = threading.Event()

    def watch() -> None:
        nonlocal most
        while not done.wait(0.002):
            most = max(most, resident())

    watcher = threading.Thread(target=watch)
    watcher.start()
    start = time.perf_counter()
    tree = fl.build(lines, cost=cost, limits=fl.Limits(**limits))
    seconds = time.perf_counter() - start
    done.set()
    watcher.join()
    return {
        "scene": scene,
        **given,
        "seconds": round(seconds, 2),
        "bytes": most - before,
        "n_refs": tree.n_refs,
        "cost": round(tree.cost(model=fl.Cost(2.0)), 1),
        "limits_hit": dict(tree.limits_hit),
    }


def read(text: str) -> dict[str, float]:
    """Return the limits of a comma-separated list of name=number."""
    try:
        return {name: float(value) for name, _, value in (part.partition("=") for part in text.split(","))}
    except ValueError:
        raise fl.InputError(f"{text!r} is not a budget; expected one such as max_refs=1000000,c_trav=2") from None


def print_budgets(scene: str, budgets: list[str]) -> None:
    """Print a line of JSON for each build."""
    context = multiprocessing.get_context("spawn")
    for limits in map(read, budgets) if budgets else BUDGETS:
        with context.Pool(1) as pool:
            print(json.dumps(pool.apply(measure, (scene, limits))), flush=True)
