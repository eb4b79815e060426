"""The worker process of one copy of fastlines: it reads requests from stdin and writes replies to stdout as JSON lines.

A request names a method of `Worker` and its arguments; the reply is the result or an error. The Python that has the
copy runs this file as a program. The file uses only public names of fastlines, so the copy can be of any version. Rays
depend only on seeds and on the scene's camera, so they are the same in every copy.
"""

from __future__ import annotations

import hashlib
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl

#: Each query: the method of the tree and its arguments. "surface" reports where a ray enters the capsule.
QUERIES: dict[str, tuple[str, dict[str, Any]]] = {
    "first": ("first_hit", {}),
    "first, surface": ("first_hit", {"at": "surface"}),
    "any": ("any_hit", {}),
    "all": ("all_hits", {}),
    "all, surface": ("all_hits", {"at": "surface"}),
    "count": ("count_hits", {}),
    "next": ("next_hits", {"k": 3}),
    "next, surface": ("next_hits", {"k": 3, "at": "surface"}),
}

#: The kinds of rays.
KINDS = ("camera", "random", "ao")


class Worker:
    """A scene, a tree over it, and rays."""

    def __init__(self) -> None:
        self.scene: Any = None
        self.tree: Any = None
        self.rays: dict[str, Any] = {}

    def hello(self, n_threads: int) -> dict[str, Any]:
        """Set the number of threads; return the version, the folder and the instruction set of this copy."""
        fl.set_num_threads(n_threads)
        self.now: Callable[[], float] = time.process_time if n_threads == 1 else time.perf_counter
        return {"version": fl.__version__, "folder": str(Path(fl.__file__).parent), "simd": fl.simd()}

    def open(self, scene: str, n_segments: int | None = None) -> str:
        """Make a scene and build the default tree; return a hash of the scene's lines."""
        self.scene = fl.scenes.make(scene, n_segments)
        self.tree = fl.build(self.scene.lines)
        return digest([self.scene.lines.segments])

    def build(self, **given: Any) -> dict[str, Any]:
        """Build a tree and its layout; return the seconds of each, and a hash of both."""
        start = self.now()
        tree = fl.build(self.scene.lines, **given)
        built = self.now()
        layout = tree.layout
        end = self.now()
        parts = [tree.nodes, tree.refs, layout.nodes, layout.leaves, layout.refs]
        return {"build": built - start, "layout": end - built, "hash": digest(parts)}

    def make_rays(self, kind: str, n_rays: int, radius: float) -> str:
        """Make about `n_rays` rays; return a hash of them."""
        low, high = self.scene.lines.bounds.astype(np.float64)
        diagonal = float(np.linalg.norm(high - low))
        rng = np.random.default_rng([n_rays, KINDS.index(kind)])
        bounds = {}
        if kind == "camera":
            size = max(1, round(n_rays**0.5))
            origins, directions = self.scene.camera.rays(size, size)
        elif kind == "random":
            directions = unit(rng.standard_normal((n_rays, 3)))
            origins = low + rng.random((n_rays, 3)) * (high - low) - 1.01 * diagonal * directions
        else:
            # Start where camera rays hit; take isotropic directions.
            origins, directions = self.scene.camera.rays(256, 256)
            t = self.tree.first_hit(origins, directions, radius).t
            hit = np.flatnonzero(np.isfinite(t))
            hit = np.sort(rng.choice(hit, n_rays))
            origins = origins[hit] + t[hit, None] * directions[hit]
            directions = unit(rng.standard_normal((n_rays, 3)))
            bounds = {"t_min": 2.5 * radius, "t_max": 0.1 * diagonal}
        arrays = {"origins": origins, "directions": directions}
        self.rays = {name: np.ascontiguousarray(each, np.float32) for name, each in arrays.items()}
        self.rays |= {"radius": radius, **bounds}
        return digest([self.rays["origins"], self.rays["directions"]])

    def time_query(self, query: str) -> float:
        """Run a query on the rays; return its seconds."""
        start = self.now()
        self._answer(query)
        return self.now() - start

    def hash_answer(self, query: str) -> str:
        """Run a query on the rays; return a hash of all columns of the answer."""
        answer = self._answer(query)
        names = ("offsets", "t", "prim", "u", "distance", "t_out")
        parts = [answer] if isinstance(answer, np.ndarray) else [getattr(answer, name, None) for name in names]
        return digest([part for part in parts if part is not None])

    def _answer(self, query: str) -> Any:
        method, arguments = QUERIES[query]
        return getattr(self.tree, method)(**self.rays, **arguments)


def unit(vectors: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return the vectors scaled to length 1."""
    scaled: np.ndarray[Any, Any] = vectors / np.sqrt((vectors**2).sum(axis=1, keepdims=True))
    return scaled


def digest(arrays: list[Any]) -> str:
    """Return a hash of the bytes of arrays."""
    found = hashlib.sha256()
    for each in arrays:
        found.update(np.ascontiguousarray(each).tobytes())
    return found.hexdigest()[:32]


def main() -> None:
    """Answer requests until stdin ends."""
    worker = Worker()
    for line in sys.stdin:
        request = json.loads(line)
        try:
            reply = {"result": getattr(worker, request["method"])(**request["arguments"])}
        except Exception as error:
            reply = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
