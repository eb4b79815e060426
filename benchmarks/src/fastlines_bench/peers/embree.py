"""Embree as a peer: the library in the wheel ``embreex``, and the configurations in which it is measured.

The loops over rays and the callbacks are compiled (benchmarks/cpp), so that the library itself is measured.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import astuple, dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from fastlines import FastlinesError, Lines

from ..harness.arrays import FloatArray
from ..harness.rays import RayBatch
from .gathering import Gathering

if TYPE_CHECKING:
    from fastlines_bench import _embree

#: The geometries in Embree: those for segments, then those for other shapes.
GEOMETRIES = {
    "user": "user geometry: boxes around capsules, and callbacks with our definition of a hit",
    "flat": "flat linear curves",
    "round": "round linear curves, with t at the entry",
    "ribbon": "two triangles a segment, facing the camera",
    "bezier": "round cubic Bezier curves, with t at the entry",
    "sphere": "spheres, with t at the entry",
    "triangle": "triangles",
}

#: The geometries to which spatial splits apply. With them, Embree reports a hit of a triangle more than once.
OF_TRIANGLES = ("ribbon", "triangle")


#: The values of RTCBuildQuality, from the fastest build to the fastest queries.
QUALITIES = ("low", "medium", "high")


@dataclass(frozen=True)
class Build:
    """The settings of an Embree scene.

    Parameters
    ----------
    geometry : str
        One of `GEOMETRIES`.
    piece_length : float
        Segments are cut into equal pieces of at most this length; 0 = whole.
    halvings : int
        Cubic curves are cut into 2**halvings parts.
    quality : str
        One of `QUALITIES`. High gives triangles spatial splits.
    replications : float
        The device's max_spatial_split_replications; 0 = its default.
    compact : bool
        RTC_SCENE_FLAG_COMPACT.
    """

    geometry: str
    piece_length: float = 0.0
    quality: str = "high"
    replications: float = 0.0
    halvings: int = 0
    compact: bool = False

    def __str__(self) -> str:
        words = [self.geometry]
        if self.splits_space:
            words.append("spatial splits" + (f" ×{self.replications:g}" if self.replications else ""))
        if self.quality == "low":
            words.append("low quality")
        if self.compact:
            words.append("compact")
        if self.geometry == "bezier" and self.halvings:
            words.append(f"{2**self.halvings} parts")
        elif self.geometry not in ("sphere", "triangle"):
            words.append(f"pieces ≤ {self.piece_length:.3g}" if self.piece_length else "whole")
        return ", ".join(words)

    @property
    def splits_space(self) -> bool:
        """Whether the builder makes spatial splits."""
        return self.geometry in OF_TRIANGLES and self.quality == "high"


@dataclass(frozen=True)
class Config:
    """A build and its queries: ray by ray (width 1) or in packets, with the hint for coherent rays or without."""

    build: Build
    width: int
    coherent: bool = False

    def __str__(self) -> str:
        query = "single" if self.width == 1 else f"packets of {self.width}{' coherent' if self.coherent else ''}"
        return f"{self.build}, {query}"

    def to_json(self) -> dict[str, Any]:
        """Return all settings, ready for JSON."""
        build = self.build
        return {
            "name": str(self),
            "geometry": build.geometry,
            "piece_length": build.piece_length,
            "quality": build.quality,
            "max_spatial_split_replications": build.replications or None,
            "parts": 2**build.halvings,
            "compact": build.compact,
            "packet_width": self.width,
            "coherent": self.coherent,
        }


def libraries() -> tuple[str, str]:
    """Return the paths of TBB ("" if there is none) and of Embree in the wheel ``embreex``."""
    spec = importlib.util.find_spec("embreex")
    if spec is None or not spec.submodule_search_locations:
        raise FastlinesError("Embree needs the package embreex: run  pip install embreex  (Linux, x86-64)")
    package = Path(next(iter(spec.submodule_search_locations)))
    folders = (package.parent / "embreex.libs", package / ".dylibs", package)

    def find(name: str) -> str:
        found = [path for folder in folders for path in sorted(folder.glob(f"lib{name}*")) if folder.is_dir()]
        return str(found[0]) if found else ""

    embree = find("embree4")
    if not embree:
        raise FastlinesError(
            f"the installed embreex ({package}) holds no libembree4; install embreex>=4.4 from a wheel"
        )
    return find("tbb"), embree


@contextmanager
def _only_cores(n_cores: int) -> Iterator[None]:
    """Run on some cores only, so that a thread pool that starts here has no more threads than those.

    The pool of Embree (TBB) has a thread for each core. With two devices, the threads that Embree may not use spin
    forever, and their time would count as ours and as Embree's.
    """
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(before)[: max(1, n_cores)])
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


@cache
def load(n_threads: int = 1) -> str:
    """Load Embree; return its version.

    Parameters
    ----------
    n_threads : int
        The maximum number of threads of Embree. Only the first call of a process sets it.

    Raises
    ------
    FastlinesError
        If embreex is not installed, or the library cannot be used here.
    """
    paths = libraries()
    try:
        from fastlines_bench import _embree
    except ImportError:
        raise FastlinesError("this build of fastlines-bench has no Embree peer: it is built on Linux only") from None
    if not _embree.instruction_set():
        raise FastlinesError("the Embree peer needs a processor with AVX2 and FMA, which this one lacks")
    try:
        with _only_cores(n_threads):
            version = _embree.load(*paths)
    except RuntimeError as error:
        raise FastlinesError(f"Embree cannot be loaded: {error}") from None
    return ".".join(map(str, version))


class Scenes:
    """Embree scenes of some lines with one radius, which are built on first use and cached.

    Curves have the radii of the lines too, if these have any. With `built_for`, the scenes are user geometry that is
    built for that larger radius.
    """

    def __init__(
        self, lines: Lines, radius: float, eye: Iterable[float], n_threads: int, built_for: float | None = None
    ) -> None:
        load(n_threads)
        self.radius, self.n_threads, self.built_for = radius, n_threads, built_for
        self._segments = np.ascontiguousarray(lines.segments, np.float32)
        thick = lines.radius is not None
        self._radii = np.ascontiguousarray(lines.end_radii if thick else np.empty((0, 2)), np.float32)
        self._vertices, self._index = np.empty(0, np.float32), np.empty(0, np.uint32)
        x, y, z = map(float, eye)
        self._eye = (x, y, z)
        self._scenes: dict[Build, _embree.Scene] = {}
        self._seconds: dict[Build, float] = {}

    @classmethod
    def of_shapes(cls, vertices: FloatArray, n_threads: int, index: npt.ArrayLike = ()) -> Scenes:
        """Return scenes of cubic curves, spheres or triangles.

        Parameters
        ----------
        vertices : (n, 4, 4), (n, 4) or (n, 3) float32
            x, y, z and radius of the control points of each curve or of each sphere; x, y, z of corners of triangles.
        n_threads : int
        index : (m, 3) array of int
            The corners of each triangle.
        """
        scenes = cls(Lines.from_segments(np.empty((0, 2, 3))), 0.0, (0.0, 0.0, 0.0), n_threads)
        scenes._vertices = np.ascontiguousarray(vertices, np.float32)
        scenes._index = np.ascontiguousarray(index, np.uint32)
        return scenes

    def get(self, build: Build) -> _embree.Scene:
        """Return the scene of a build."""
        if build not in self._scenes:
            from fastlines_bench import _embree

            from ..harness.clock import clock

            device = f"threads={self.n_threads}"
            if build.replications:
                device += f",max_spatial_split_replications={build.replications:g}"
            now = clock(self.n_threads)
            start = now()
            self._scenes[build] = _embree.Scene(
                self._segments,
                self._radii,
                self._vertices,
                self._index,
                build.geometry,
                self.built_for or self.radius,
                build.piece_length,
                build.halvings,
                build.quality,
                build.compact,
                device,
                self._eye,
            )
            self._seconds[build] = now() - start
            self._scenes[build].radius = self.radius
        return self._scenes[build]

    def forget(self) -> None:
        """Free all scenes, but keep their build times."""
        self._scenes.clear()

    def build_seconds(self, build: Build) -> float:
        """Return the seconds of a build."""
        self.get(build)
        return self._seconds[build]

    def query(self, config: Config, query: str, rays: RayBatch) -> Any:
        """Return the answer to a query, "first", "any" or "all", as Embree's loops over rays give it."""
        scene = self.get(config.build)
        method = {"first": scene.first_hit, "any": scene.any_hit, "all": scene.all_hits}[query]
        return method(
            rays.origins, rays.directions, rays.t_min, rays.t_max, config.width, config.coherent, self.n_threads
        )

    def gather(self, config: Config, given: Gathering, rays: RayBatch, powers: FloatArray) -> FloatArray:
        """Return the sums over the beams that each ray crosses, (n_rays, 3) float32; for user geometry."""
        how = rays.t_min, rays.t_max, config.width, config.coherent, self.n_threads
        sums = self.get(config.build).gather(rays.origins, rays.directions, *how, astuple(given), powers.reshape(-1))
        return sums.reshape(-1, 3)


def widths(scenes: Scenes, build: Build) -> list[int]:
    """Return the packet widths that Embree traces natively on this processor; it would split others."""
    return [width for width in (1, 8, 16) if scenes.get(build).is_native(width)]


def configs(
    scenes: Scenes, builds: Iterable[Build], query: str, rays: RayBatch, one_by_one: bool = False
) -> list[Config]:
    """Return all configurations in which these rays can be queried."""
    found = []
    for build in builds:
        if scenes.built_for is not None and build.geometry != "user":
            continue
        # Ribbons face the camera; and spatial splits make Embree report a hit of a triangle more than once.
        if (build.geometry == "ribbon" and not rays.coherent) or (query == "all" and build.splits_space):
            continue
        for width in [1] if one_by_one else widths(scenes, build):
            found.append(Config(build, width))
            if width > 1 and rays.coherent:
                found.append(replace(found[-1], coherent=True))
    return found
