"""Variants of the kernels on one GPU, timed in turn on the same rays, with answers compared with those of the CPU."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

import fastlines as fl
from fastlines.scenes import RADII, make

from ..harness import machine
from ..harness.clock import best_in_turn, timed
from ..harness.internals import TUNING, CudaBackend, CudaDevice, cuda_device, upload_scene
from ..harness.preset import Preset, sized
from ..harness.rays import RayBatch, camera_rays, random_rays
from .run import TIMED, checked, device_query, sorted_rays

#: A variant: macros of the kernels, by the names of `TUNING`, which are not as they are in the package.
Variant = dict[str, int]

#: The variants that are timed: a ray a thread, with the stack in local memory or partly in shared memory, and a ray a
#: group of lanes, likewise.
VARIANTS: tuple[Variant, ...] = (
    {},
    {"FASTLINES_NODE_ROWS": 1},
    {"FASTLINES_BLOCK": 64},
    {"FASTLINES_BLOCK": 256},
    {"FASTLINES_SHARED_STACK": 8},
    {"FASTLINES_SHARED_STACK": 24},
    {"FASTLINES_GROUP": 16},
    {"FASTLINES_GROUP": 16, "FASTLINES_SHARED_STACK": 16},
    {"FASTLINES_GROUP": 16, "FASTLINES_SHARED_STACK": 64},
    {"FASTLINES_GROUP": 16, "FASTLINES_SHARED_STACK": 64, "FASTLINES_BLOCK": 256},
)


@dataclass(frozen=True, kw_only=True)
class VariantsPreset(Preset):
    """How much to measure.

    Parameters
    ----------
    scenes : tuple of str
    variants : tuple of dict of str to int
    n_segments, n_rays : int
    radius : float
    rounds : int
        How many calls are made; the fastest counts.
    limit : float
        The time in seconds after which no scene is begun.
    """

    scenes: tuple[str, ...] = ("bun-hair",)
    variants: tuple[Variant, ...] = VARIANTS
    n_segments: int = sized(100_000, 1_000)
    n_rays: int = sized(1 << 20, 1 << 12)
    radius: float = RADII["M"]
    rounds: int = sized(5, 2)
    limit: float = 420.0


@dataclass(frozen=True)
class VariantCell:
    """The seconds of one query with one variant, and whether its answer is that of the CPU."""

    scene: str
    kind: str
    query: str
    variant: Variant
    n_rays: int
    gpu_s: float
    same: bool

    @property
    def mrays(self) -> float:
        """Millions of rays per second."""
        return self.n_rays / self.gpu_s / 1e6


@dataclass
class VariantsResult:
    """All figures; `compile_s` are the seconds in which each variant was compiled, or taken from the cache."""

    preset: VariantsPreset
    card: str
    machine: dict[str, object]
    compile_s: list[float] = field(default_factory=list)
    cells: list[VariantCell] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    seconds: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON."""
        return asdict(self) | {
            "format": "fastlines-bench cuda-variants 1",
            "cells": [asdict(cell) | {"mrays": cell.mrays} for cell in self.cells],
        }

    @property
    def agrees(self) -> bool:
        """Whether all answers are the same."""
        return all(cell.same for cell in self.cells)


def run_variants(preset: VariantsPreset, progress: Callable[[str, float], None]) -> VariantsResult:
    """Compare and time all variants. Raises an error if there is no GPU."""
    begin = time.perf_counter()
    device = cuda_device()
    result = VariantsResult(preset, device.name, machine.describe())
    for i, name in enumerate(preset.scenes):
        if time.perf_counter() - begin > preset.limit:
            result.left_out.append(name)
            continue
        progress(name, i / len(preset.scenes))
        measure_variants(preset, name, device, result)
    result.seconds = time.perf_counter() - begin
    return result


def measure_variants(preset: VariantsPreset, name: str, device: CudaDevice, result: VariantsResult) -> None:
    """Time the queries on one scene, the variants in turn."""
    scene = make(name, preset.n_segments)
    tree = fl.build(scene.lines)
    backends = [backend_of(variant, tree, device, result) for variant in preset.variants]
    random = random_rays(scene.lines, preset.n_rays)
    for batch in (camera_rays(scene.camera, preset.n_rays), random, sorted_rays(random, scene.lines.bounds)):
        for query in TIMED:
            expected = columns(getattr(tree.to("cpu"), query)(batch.origins, batch.directions, preset.radius))
            runs = [device_query(backend, tree, batch, preset.radius, query) for backend in backends]
            found = best_in_turn(preset.rounds, *(timed(run) for run in runs))
            for variant, backend, (seconds, _) in zip(preset.variants, backends, found, strict=True):
                given = columns_on_device(backend, tree, batch, preset.radius, query)
                same = all(np.array_equal(*pair) for pair in zip(given, expected, strict=True))
                result.cells.append(VariantCell(name, batch.kind, query, variant, len(batch), seconds, same))


def backend_of(variant: Variant, tree: fl.Tree, device: CudaDevice, result: VariantsResult) -> CudaBackend:
    """Return a tree on the device, with kernels of a variant."""
    begin = time.perf_counter()
    with tuned(variant):
        backend = CudaBackend(upload_scene(tree.layout, device, False, None))
    result.compile_s.append(time.perf_counter() - begin)
    return backend


@contextmanager
def tuned(variant: Variant) -> Iterator[None]:
    """Compile kernels of a variant for a while."""
    before = TUNING.copy()
    try:
        TUNING.update(variant)
        yield
    finally:
        TUNING.update(before)


def columns(answer: Any) -> list[npt.NDArray[Any]]:
    """Return the columns of an answer of the CPU."""
    names = ("t", "prim", "u", "distance", "offsets")
    return [getattr(answer, name) for name in names if hasattr(answer, name)] or [answer]


def columns_on_device(
    backend: CudaBackend, tree: fl.Tree, batch: RayBatch, radius: float, query: str
) -> list[npt.NDArray[Any]]:
    """Return the same columns of the device's answer."""
    rays = checked(tree, batch, radius)
    if query == "first_hit":
        return [column for column in backend.first_hit(rays, "closest", None) if column is not None]
    if query == "any_hit":
        return [backend.any_hit(rays, "closest", None)]
    if query == "count_hits":
        return [backend.count_hits(rays, "closest", None)]
    offsets, found = backend.list_hits(rays, "closest", None, False, None)
    return [*(column for column in found if column is not None), offsets]
