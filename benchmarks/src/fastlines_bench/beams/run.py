"""The parts of the benchmark, and how much each of them measures."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from ..harness import machine
from ..harness.figures import Figures
from ..harness.preset import Preset, sized
from ..peers import embree, mitsuba
from ..peers.beam_loops import load_loops

#: The parts, in the order in which they run.
PARTS = ("point-light", "gather", "passes", "radii", "caustic")


@dataclass(frozen=True, kw_only=True)
class BeamsPreset(Preset):
    """How much to measure.

    Parameters
    ----------
    parts : tuple of str
        Some of `PARTS`.
    n_threads : int
        The number of threads of all sides.
    rounds : int
        How often each side gathers.
    floors : bool
        Whether times and memory are compared with those that are wanted, which are for full size.
    method, methods : str, tuple of str
        How our tree is built; in the part ``passes``, the fastest of several.
    size : int
        The width and the height of the pictures of the cube in pixels.
    beams : tuple of int
        The part ``gather``: numbers of beams.
    peer_rays, listed_rays, brute_rays, memory_rays : int
        About how many rays Embree and the grid get, are listed, get brute force, and are gathered for the memory.
    point_beams, point_passes, point_radii, cut_beams : int, int, (float, float), int
        The part ``point-light``: beams of each kind, independent passes, radii, beams that are cut.
    pass_beams, passes, pass_radius : int, int, float
        The part ``passes``: beams of each pass, passes, and the first radius.
    radii_beams, radii : int, tuple of float
        The part ``radii``.
    caustic_size, caustic_paths, caustic_radius : int, int, float
        The part ``caustic``: the width of the picture, photons a pass, and the first radius.
    caustic_s, reference_s : float
        The seconds of each side, and those of the reference.
    variant : str
        That of Mitsuba.
    """

    parts: tuple[str, ...] = PARTS
    n_threads: int = 1
    rounds: int = sized(3, 1)
    floors: bool = sized(True, False)
    method: str = "best"
    methods: tuple[str, ...] = sized(("best", "bvh-cl"), ("bvh-cl",))
    size: int = sized(512, 64)
    beams: tuple[int, ...] = sized((36_294, 1_000_000), (5_000,))
    peer_rays: int = sized(1 << 15, 1 << 12)
    listed_rays: int = sized(1 << 14, 1 << 11)
    brute_rays: int = sized(1 << 10, 1 << 8)
    memory_rays: int = sized(1 << 14, 1 << 12)
    point_beams: int = sized(4_000_000, 40_000)
    point_passes: int = sized(40, 20)
    point_radii: tuple[float, float] = (0.005, 0.02)
    cut_beams: int = sized(20_000, 1_000)
    pass_beams: int = sized(100_000, 5_000)
    passes: int = sized(30, 3)
    pass_radius: float = 0.003
    radii_beams: int = sized(100_000, 5_000)
    radii: tuple[float, ...] = sized((0.0005, 0.001, 0.002, 0.003, 0.004, 0.005), (0.001, 0.005))
    caustic_size: int = sized(128, 32)
    caustic_paths: int = sized(50_000, 5_000)
    caustic_radius: float = 0.02
    caustic_s: float = sized(40.0, 2.0)
    reference_s: float = sized(160.0, 4.0)
    variant: str = "llvm_ad_rgb"


@dataclass(frozen=True)
class BeamsResult:
    """The figures of all parts."""

    machine: dict[str, Any]
    preset: BeamsPreset
    parts: list[Figures]
    seconds: float

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {
            "format": "fastlines-bench beams 1",
            "machine": self.machine,
            "preset": asdict(self.preset),
            "seconds": self.seconds,
            "parts": [part.to_json() for part in self.parts],
        }


def run_beams(
    preset: BeamsPreset,
    progress: Callable[[str, float], None] = lambda what, share: None,
    found: Callable[[Figures], None] = lambda figures: None,
) -> BeamsResult:
    """Measure the parts of a preset; `found` is called with each as soon as it is done.

    Raises
    ------
    FastlinesError
        If a peer of one of the parts is missing.
    """
    _load_peers(preset)
    from .caustic import CausticSize, run_caustic
    from .gather import GatherSize, run_gather
    from .passes import run_passes
    from .point_light import run_point_light
    from .radii import run_radii

    start, n_threads = time.perf_counter(), preset.n_threads
    gathers = GatherSize(
        preset.beams,
        preset.size,
        preset.peer_rays,
        preset.listed_rays,
        preset.brute_rays,
        preset.memory_rays,
        preset.method,
        preset.rounds,
        preset.floors,
        n_threads,
    )
    caustic = CausticSize(
        preset.caustic_size,
        preset.caustic_paths,
        preset.caustic_radius,
        preset.caustic_s,
        preset.reference_s,
        preset.variant,
        preset.floors,
        n_threads,
    )
    calls: dict[str, Callable[[], Figures]] = {
        "point-light": lambda: run_point_light(
            preset.point_beams, preset.point_passes, preset.point_radii, preset.cut_beams, progress
        ),
        "gather": lambda: run_gather(gathers, progress),
        "passes": lambda: run_passes(
            preset.pass_beams,
            preset.passes,
            preset.pass_radius,
            preset.size,
            preset.methods,
            preset.floors,
            n_threads,
            progress,
        ),
        "radii": lambda: run_radii(preset.radii_beams, preset.radii, preset.size, preset.method, n_threads, progress),
        "caustic": lambda: run_caustic(caustic, progress),
    }
    parts = []
    for name in preset.parts:
        parts.append(calls[name]())
        found(parts[-1])
    return BeamsResult(machine.describe(threads=n_threads), preset, parts, time.perf_counter() - start)


def _load_peers(preset: BeamsPreset) -> None:
    """Raise an error before the work if a peer cannot be used."""
    if set(preset.parts) & {"gather", "passes", "radii"}:
        embree.load(preset.n_threads)
    if "gather" in preset.parts:
        load_loops()
    if "caustic" in preset.parts:
        mitsuba.load(preset.variant, preset.n_threads)
