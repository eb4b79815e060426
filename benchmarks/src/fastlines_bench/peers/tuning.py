"""The tuned lengths to which segments are cut for Embree: a small sweep for each scene, cached for the user."""

from __future__ import annotations

import hashlib
import json
import math
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fastlines import Lines

from ..harness.clock import clock
from ..harness.rays import RayBatch
from .embree import Build, Config, Scenes, load, widths

#: The lengths of the sweep, as shares of the box's diagonal; 0 = whole segments.
LENGTHS = (0.0, 1 / 8, 1 / 16, 1 / 32, 1 / 64, 1 / 128)

#: The builds that are tuned.
VARIANTS = (
    Build("user"),
    Build("flat"),
    Build("round"),
    Build("ribbon", quality="medium"),
    Build("ribbon"),
    Build("ribbon", replications=8.0),
)

#: The maximum number of pieces, above which a length is skipped.
MAX_PIECES = 1_500_000


def cache_file() -> Path:
    """Return the path of the file with tuned lengths, in the user's cache folder."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = str(Path.home() / "Library" / "Caches")
    else:
        base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "fastlines" / "embree-tuning.json"


def tuned_builds(
    lines: Lines,
    scenes: Scenes,
    batches: Sequence[RayBatch],
    queries: Sequence[str],
    *,
    lengths: Sequence[float] = LENGTHS,
    variants: Sequence[Build] = VARIANTS,
    retune: bool = False,
    progress: Callable[[str], None] = lambda what: None,
) -> dict[str, list[Build]]:
    """Return the fastest builds of each variant for each query; tune those that are not cached.

    Parameters
    ----------
    lines : Lines
    scenes : Scenes
        The scenes of the lines with the radius to tune for.
    batches : sequence of RayBatch
        The timed rays; the best length has the highest geometric mean rate over them.
    queries : sequence of str
        The queries, each of which has its own best length.
    variants : sequence of Build
        The builds to tune.

    Returns
    -------
    dict of str to list of Build
        The best build of each variant, for each query.
    """
    key = _key(lines, scenes, batches, lengths)
    known = _read()
    entry: dict[str, dict[str, float]] = {} if retune else known.get(key, {})
    low, high = lines.bounds.astype(np.float64)
    diagonal = float(np.sqrt(((high - low) ** 2).sum()))
    total = float(np.sqrt(((lines.segments[:, 1] - lines.segments[:, 0]).astype(np.float64) ** 2).sum(axis=1)).sum())
    tried = [share * diagonal for share in lengths]
    tried = [length for length in tried if length == 0 or len(lines) + total / length <= MAX_PIECES]

    for variant in variants:
        wanted = [query for query in queries if _applies(variant, query, batches)]
        if all(query in entry.get(str(variant), {}) for query in wanted):
            continue
        progress(f"tuning Embree: {variant}")
        rates: dict[str, list[float]] = {query: [] for query in wanted}
        for length in tried:
            build = _with_length(variant, length)
            for query in wanted:
                rates[query].append(_rate(scenes, build, query, batches))
            scenes.forget()
        best = {query: tried[int(np.argmax(rates[query]))] for query in wanted}
        entry[str(variant)] = {**entry.get(str(variant), {}), **best}
        known[key] = entry
        _write(known)
    return {
        query: [
            _with_length(variant, entry[str(variant)][query])
            for variant in variants
            if query in entry.get(str(variant), {}) and _applies(variant, query, batches)
        ]
        for query in queries
    }


def usual_build(builds: dict[str, list[Build]], scenes: Scenes, batches: Sequence[RayBatch]) -> Build:
    """Return the build of `tuned_builds` that is fastest for all queries and rays together.

    Ribbons are left out, because they do not support all queries.
    """
    every = dict.fromkeys(build for found in builds.values() for build in found if build.geometry != "ribbon")
    rates = {build: math.prod(_rate(scenes, build, query, batches) for query in builds) for build in every}
    scenes.forget()
    return max(rates, key=lambda build: rates[build])


def _applies(variant: Build, query: str, batches: Sequence[RayBatch]) -> bool:
    if variant.geometry != "ribbon":
        return True
    return any(rays.coherent for rays in batches) and query != "any" and not (query == "all" and variant.splits_space)


def _with_length(variant: Build, length: float) -> Build:
    return replace(variant, piece_length=length)


def _rate(scenes: Scenes, build: Build, query: str, batches: Sequence[RayBatch]) -> float:
    """Return the geometric mean of rays per second over the batches, each with the fastest width."""
    now = clock(scenes.n_threads)
    logs = []
    for rays in batches:
        if build.geometry == "ribbon" and not rays.coherent:
            continue
        seconds = []
        for width in widths(scenes, build)[:2]:
            for _ in range(2):
                start = now()
                scenes.query(Config(build, width, coherent=rays.coherent and width > 1), query, rays)
                seconds.append(now() - start)
        logs.append(math.log(len(rays) / max(min(seconds), 1e-9)))
    return math.exp(sum(logs) / len(logs))


def _key(lines: Lines, scenes: Scenes, batches: Sequence[RayBatch], lengths: Sequence[float]) -> str:
    """Return a hash of everything that the best length depends on."""
    digest = hashlib.sha256(np.ascontiguousarray(lines.segments).tobytes())
    if lines.radius is not None:
        digest.update(lines.radius.tobytes())
    digest.update(repr((load(), scenes.radius, tuple(lengths), [(b.kind, len(b)) for b in batches])).encode())
    return digest.hexdigest()[:32]


def _read() -> dict[str, Any]:
    try:
        known = json.loads(cache_file().read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}


def _write(known: dict[str, Any]) -> None:
    path = cache_file()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
        partial.write_text(json.dumps(known, indent=1), encoding="utf-8")
        partial.replace(path)
    except OSError:
        return  # the cache only saves time
