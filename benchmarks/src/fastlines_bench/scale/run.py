"""The parts of the benchmark, and how much each of them measures."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from fastlines.scenes import NAMES

from ..harness import machine
from ..harness.figures import Figures
from ..harness.preset import Preset, sized

#: The parts, in the order in which they run.
PARTS = ("answers", "memory", "cluster", "kills", "restarts", "growth")


@dataclass(frozen=True, kw_only=True)
class ScalePreset(Preset):
    """How much to measure.

    Parameters
    ----------
    parts : tuple of str
        Some of `PARTS`.
    n_segments : int
        The largest scene, which is built and queried within `limit`.
    limit : int
        The bytes of addresses of that process.
    n_small : int
        The scene whose answers are compared with those of one tree in memory.
    """

    parts: tuple[str, ...] = PARTS
    n_segments: int = sized(50_000_000, 200_000)
    limit: int = sized(4_000_000_000, 2_000_000_000)
    n_small: int = sized(5_000_000, 50_000)
    n_rays: int = sized(1_000_000, 20_000)
    scenes: tuple[str, ...] = sized(NAMES, ("spaghetti", "straight-hair"))
    scene_segments: int | None = sized(None, 500)
    tiles: tuple[int, ...] = sized((1, 7, 64), (1, 7))
    answer_rays: int = sized(20_000, 500)
    cluster_segments: int = sized(5_000_000, 50_000)
    cluster_rays: int = sized(20_000_000, 100_000)
    rounds: int = sized(3, 1)
    kill_rays: int = sized(1_000_000, 200_000)
    kills: int = sized(20, 2)
    growth_sizes: tuple[int, ...] = sized((100_000, 1_000_000, 10_000_000, 50_000_000), (20_000, 100_000))
    growth_rays: tuple[int, ...] = sized((100_000, 1_000_000, 10_000_000, 100_000_000), (10_000, 100_000))
    growth_tiles: tuple[int, ...] = sized((1, 4, 16, 64), (1, 4))


@dataclass(frozen=True)
class Scale:
    """The figures of all parts."""

    machine: dict[str, Any]
    preset: ScalePreset
    parts: list[Figures]
    seconds: float

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {
            "format": "fastlines-bench scale 1",
            "machine": self.machine,
            "preset": asdict(self.preset),
            "seconds": self.seconds,
            "parts": [part.to_json() for part in self.parts],
        }


def run_scale(
    preset: ScalePreset,
    progress: Callable[[str, float], None] = lambda what, share: None,
    found: Callable[[Figures], None] = lambda figures: None,
) -> Scale:
    """Measure the parts of a preset; `found` is called with each as soon as it is done."""
    from .answers import run_answers
    from .cluster import run_cluster
    from .growth import run_growth
    from .kills import run_kills
    from .memory import run_memory
    from .restarts import run_restarts

    start, n_tiles = time.perf_counter(), 16
    middle = preset.cluster_segments
    calls: dict[str, Callable[[], Figures]] = {
        "answers": lambda: run_answers(
            preset.scenes, preset.scene_segments, preset.tiles, preset.answer_rays, progress
        ),
        "memory": lambda: run_memory(preset.n_segments, preset.n_small, preset.limit, preset.n_rays, progress),
        "cluster": lambda: run_cluster(middle, n_tiles, preset.cluster_rays, preset.rounds, progress),
        "kills": lambda: run_kills(middle, n_tiles, preset.kill_rays, preset.kills, progress),
        "restarts": lambda: run_restarts(middle, n_tiles, preset.kills, progress),
        "growth": lambda: run_growth(
            preset.growth_sizes, preset.growth_rays, preset.growth_tiles, middle, preset.n_rays, progress
        ),
    }
    parts = []
    for name in preset.parts:
        parts.append(calls[name]())
        found(parts[-1])
    return Scale(machine.describe(), preset, parts, time.perf_counter() - start)
