"""Queries on a GPU: answers compared with brute force, and rays per second beside our own kernels of the CPU.

The seconds of a query on the GPU are those with rays and answers in its memory, by the wall clock, until the device is
done. Those with NumPy arrays include the copies.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

import fastlines as fl
from fastlines.scenes import NAMES, RADII, make

from ..harness import machine
from ..harness.arrays import FloatArray
from ..harness.clock import best_of
from ..harness.compare import same
from ..harness.internals import TUNING, CudaBackend, CudaDevice, RayArguments, check_query, cuda_device, scene_of
from ..harness.preset import Preset, sized
from ..harness.rays import RayBatch, camera_rays, random_rays
from ..peers.warp import WarpScene, warp

#: The queries that are compared with brute force, and their options.
COMPARED: tuple[tuple[str, dict[str, Any]], ...] = (
    *((query, {"at": at}) for query in ("first_hit", "all_hits") for at in ("closest", "surface")),
    *(("next_hits", {"k": 4, "at": at}) for at in ("closest", "surface")),
    ("next_hits", {"k": 4, "rank": "distance"}),
    ("any_hit", {}),
    ("count_hits", {}),
)

#: The queries that are timed.
TIMED = ("first_hit", "any_hit", "count_hits", "all_hits")

#: The bytes of a node or leaf, and of a reference.
BLOCK, REFERENCE = 128, 8

#: The bytes that are copied to measure the speed of uploads.
UPLOADED = 1 << 28


@dataclass(frozen=True, kw_only=True)
class CudaPreset(Preset):
    """How much to compare and to measure.

    Parameters
    ----------
    scenes : tuple of str
    n_compared_segments, n_compared_rays : int
        The segments of each scene and the rays of each radius that are compared with brute force.
    n_segments, n_rays : int
        The segments of each scene and the rays that are timed.
    radius : float
        The radius of timed rays.
    rounds : int
        How many calls are made; the fastest counts.
    limit : float
        The time in seconds after which no scene is begun.
    tuning : dict of str to int
        Macros of the kernels, by the names of `TUNING`.
    warp : str
        The device of Warp, which is measured too if it is installed; empty for none.
    """

    scenes: tuple[str, ...] = NAMES
    n_compared_segments: int = sized(20_000, 300)
    n_compared_rays: int = sized(512, 64)
    n_segments: int = sized(100_000, 1_000)
    n_rays: int = sized(1 << 20, 1 << 12)
    radius: float = RADII["M"]
    rounds: int = sized(5, 2)
    limit: float = 420.0
    tuning: dict[str, int] = field(default_factory=TUNING.copy)
    warp: str = "cuda"


@dataclass(frozen=True)
class Comparison:
    """The comparison of one scene with brute force: pairs of a ray and a segment, and answers that differ."""

    scene: str
    n_decisions: int
    n_queries: int
    differing: list[str]


@dataclass(frozen=True)
class CudaCell:
    """The seconds of one query; `steps` are the nodes, leaves and exact tests of a ray, for first hits."""

    scene: str
    kind: str
    query: str
    n_rays: int
    n_hits: int
    gpu_s: float
    copied_s: float
    cpu_s: float
    same: bool
    steps: tuple[float, float, float] | None
    bytes_per_ray: float | None
    #: Warp's seconds, and the share of rays whose answer differs from ours; None without Warp or such a kernel.
    warp_s: float | None
    warp_differs: float | None

    def to_json(self) -> dict[str, Any]:
        """Return the fields, and rays per second."""
        rates = {"gpu_mrays": self.gpu_s, "copied_mrays": self.copied_s, "cpu_mrays": self.cpu_s}
        return asdict(self) | {name: self.n_rays / seconds / 1e6 for name, seconds in rates.items()}


@dataclass
class CudaResult:
    """All figures."""

    preset: CudaPreset
    card: str
    machine: dict[str, object]
    upload_gb_s: float = 0.0
    comparisons: list[Comparison] = field(default_factory=list)
    cells: list[CudaCell] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    seconds: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON."""
        return {
            "format": "fastlines-bench cuda 1",
            "machine": self.machine,
            "card": self.card,
            "preset": asdict(self.preset),
            "upload_gb_s": self.upload_gb_s,
            "comparisons": [asdict(each) for each in self.comparisons],
            "cells": [cell.to_json() for cell in self.cells],
            "left_out": self.left_out,
            "seconds": self.seconds,
        }

    @property
    def agrees(self) -> bool:
        """Whether all answers are the same."""
        return not any(each.differing for each in self.comparisons) and all(cell.same for cell in self.cells)


def run_cuda(preset: CudaPreset, progress: Callable[[str, float], None]) -> CudaResult:
    """Compare and measure. Raises an error if there is no GPU."""
    begin = time.perf_counter()
    device = cuda_device()
    TUNING.update(preset.tuning)
    result = CudaResult(preset, device.name, machine.describe())
    tasks = [(compare_answers, name) for name in preset.scenes] + [(measure, name) for name in preset.scenes]
    result.upload_gb_s = upload_speed(device)
    for i, (task, name) in enumerate(tasks):
        if time.perf_counter() - begin > preset.limit:
            result.left_out.append(f"{task.__name__} {name}")
            continue
        progress(f"{task.__name__} {name}", i / len(tasks))
        task(preset, name, device, result)
    result.seconds = time.perf_counter() - begin
    return result


def upload_speed(device: CudaDevice) -> float:
    """Return how many GB are copied to the device per second."""
    array = np.zeros(UPLOADED, np.uint8)
    seconds, _ = best_of(3, 2, lambda: device.upload(array))
    return UPLOADED / seconds / 1e9


def compare_answers(preset: CudaPreset, name: str, device: CudaDevice, result: CudaResult) -> None:
    """Compare the answers of the GPU with those of brute force, on one scene and all radii."""
    scene = make(name, preset.n_compared_segments)
    tree = fl.build(scene.lines).to("cuda")
    half = preset.n_compared_rays // 2
    differing, n_decisions, n_queries = [], 0, 0
    for batch in (camera_rays(scene.camera, half), random_rays(scene.lines, half)):
        for label, radius in RADII.items():
            rays = batch.origins, batch.directions, radius
            for query, how in COMPARED:
                expected = fl.brute_force(scene.lines, *rays, query=query, **how)  # type: ignore[arg-type]
                if not same(getattr(tree, query)(*rays, **how), expected):
                    differing.append(f"{batch.kind} rays, radius {label}, {query}, {how}")
                n_decisions += len(batch) * len(scene.lines)
                n_queries += 1
    result.comparisons.append(Comparison(name, n_decisions, n_queries, differing))


def measure(preset: CudaPreset, name: str, device: CudaDevice, result: CudaResult) -> None:
    """Time the queries on one scene: on the GPU without and with copies, and on the CPU with all threads."""
    scene = make(name, preset.n_segments)
    tree = fl.build(scene.lines)
    on_gpu, on_cpu = tree.to("cuda"), tree.to("cpu")
    backend = CudaBackend(scene_of(tree.layout, device))
    peer = WarpScene(scene.lines, preset.warp) if preset.warp and warp() else None
    item = scene.lines.core_rows.itemsize * scene.lines.core_rows.shape[1]
    random = random_rays(scene.lines, preset.n_rays)
    for batch in (camera_rays(scene.camera, preset.n_rays), random, sorted_rays(random, scene.lines.bounds)):
        rays = batch.origins, batch.directions, preset.radius
        for query in TIMED:
            run = device_query(backend, tree, batch, preset.radius, query)
            gpu_s, _ = best_of(preset.rounds, 2, run)
            copied_s, given = best_of(2, 2, partial(getattr(on_gpu, query), *rays))
            cpu_s, expected = best_of(2, 2, partial(getattr(on_cpu, query), *rays))
            steps = count_steps(backend, tree, batch, preset.radius) if query == "first_hit" else None
            theirs = peer and peer.query(query, batch, preset.radius)
            warp_s = best_of(preset.rounds, 2, theirs.run)[0] if theirs else None
            cell = CudaCell(
                scene=name,
                kind=batch.kind,
                query=query,
                n_rays=len(batch),
                n_hits=n_hits(query, expected),
                gpu_s=gpu_s,
                copied_s=copied_s,
                cpu_s=cpu_s,
                same=same(given, expected),
                steps=steps,
                bytes_per_ray=None if steps is None else BLOCK * (steps[0] + steps[1]) + (REFERENCE + item) * steps[2],
                warp_s=warp_s,
                warp_differs=float((theirs.answer() != _prims(expected)).mean()) if theirs else None,
            )
            result.cells.append(cell)


def sorted_rays(batch: RayBatch, bounds: FloatArray) -> RayBatch:
    """Return rays sorted by the octant of their direction, then along a Morton curve by where they pass the centre."""
    low, high = np.asarray(bounds, np.float64)
    from_centre = batch.origins - (low + high) / 2
    along = (from_centre * batch.directions).sum(axis=1, keepdims=True)
    nearest = (from_centre - along * batch.directions) / float((high - low).max()) + 0.5
    cells = (np.clip(nearest, 0, 0.9999) * 1024).astype(np.int64)
    key = ((batch.directions < 0) @ np.array([1, 2, 4])).astype(np.int64) << 30
    for bit in range(10):
        for axis in range(3):
            key |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return replace(batch.take(np.argsort(key, kind="stable")), kind="sorted")


def device_query(
    backend: CudaBackend, tree: fl.Tree, batch: RayBatch, radius: float, query: str
) -> Callable[[], object]:
    """Return a function that answers rays in the memory of the GPU, and waits until the GPU is done."""
    device, rays = backend.scene.device, backend.upload(checked(tree, batch, radius))

    def run() -> object:
        if query == "first_hit":
            return device.download(backend.find_first(rays, "closest").t, np.float32, 1)
        if query == "any_hit":
            return device.download(backend.find_any(rays, "closest"), np.bool_, 1)
        if query == "count_hits":
            return device.download(backend.count(rays, "closest"), np.int64, 1)
        lists = backend.list(rays, "closest", None, False)
        return device.download(lists.columns.t, np.float32, min(1, lists.columns.n))

    return run


def count_steps(backend: CudaBackend, tree: fl.Tree, batch: RayBatch, radius: float) -> tuple[float, float, float]:
    """Return the mean number of nodes, leaves and exact tests of a ray that searches for its first hit."""
    rays = backend.upload(checked(tree, batch, radius))
    steps = backend.scene.device.download(backend.count_steps(rays), np.uint32, 3 * len(batch))
    nodes, leaves, tests = steps.reshape(-1, 3).mean(axis=0)
    return float(nodes), float(leaves), float(tests)


def checked(tree: fl.Tree, batch: RayBatch, radius: float) -> Any:
    """Return checked rays."""
    given = RayArguments(batch.origins, batch.directions, radius, t_min=batch.t_min, t_max=batch.t_max)
    return check_query(tree.geometry, tree.nodes["box"][0], given)


def _prims(answer: Any) -> Any:
    """Return the primitives of first hits, or counts."""
    return getattr(answer, "prim", answer)


def n_hits(query: str, answer: Any) -> int:
    """Return the number of hits of an answer; of rays that hit, for first and any."""
    if query == "first_hit":
        return int(answer.hit.sum())
    return len(answer) if query == "all_hits" else int(answer.sum())


def describe(result: CudaResult) -> str:
    """Return the number of threads of the CPU, and the number of decisions that were compared."""
    n_decisions = sum(each.n_decisions for each in result.comparisons)
    n_queries = sum(each.n_queries for each in result.comparisons)
    what = f"{n_queries:,} queries, {n_decisions:,} pairs of a ray and a segment"
    return f"{fl.get_num_threads()} threads on the CPU; {what}"
