"""One copy of fastlines, which takes orders over a pipe: one JSON object a line in, and one out.

It is run as a program by the Python that has the copy, and uses nothing of fastlines but its public names, so the copy
can be of any version. Rays come from seeds and from the scene's camera, and are the same in every copy.
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

#: The names of all queries, what is called, and with which arguments; "surface" is a hit's other definition.
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

#: All kinds of rays.
KINDS = ("camera", "random", "ao")


class Worker:
    """A scene, a tree over it, and rays to ask."""

    def __init__(self) -> None:
        self.scene: Any = None
        self.tree: Any = None
        self.rays: dict[str, Any] = {}

    def hello(self, n_threads: int) -> dict[str, Any]:
        """Set the number of threads; tell which copy this is."""
        fl.set_num_threads(n_threads)
        self.now: Callable[[], float] = time.process_time if n_threads == 1 else time.perf_counter
        return {"version": fl.__version__, "folder": str(Path(fl.__file__).parent), "simd": fl.simd()}

    def open(self, scene: str, n_segments: int | None = None) -> str:
        """Make a scene and the default tree over it; return a hash of its lines."""
        self.scene = fl.scenes.make(scene, n_segments)
        self.tree = fl.build(self.scene.lines)
        return digest([self.scene.lines.segments])

    def build(self, **given: Any) -> dict[str, Any]:
        """Build a tree; return the seconds of the tree and of its layout, and a hash of both."""
        start = self.now()
        tree = fl.build(self.scene.lines, **given)
        built = self.now()
        layout = tree.layout
        laid = self.now()
        parts = [tree.nodes, tree.refs, layout.nodes, layout.leaves, layout.refs]
        return {"build": built - start, "layout": laid - built, "hash": digest(parts)}

    def make_rays(self, kind: str, n_rays: int, radius: float) -> str:
        """Make rays, about so many; return a hash of them."""
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
            # From what the camera sees, over the sphere.
            origins, directions = self.scene.camera.rays(256, 256)
            t = self.tree.first_hit(origins, directions, radius).t
            seen = np.flatnonzero(np.isfinite(t))
            seen = np.sort(rng.choice(seen, n_rays))
            origins = origins[seen] + t[seen, None] * directions[seen]
            directions = unit(rng.standard_normal((n_rays, 3)))
            bounds = {"t_min": 2.5 * radius, "t_max": 0.1 * diagonal}
        arrays = {"origins": origins, "directions": directions}
        self.rays = {name: np.ascontiguousarray(each, np.float32) for name, each in arrays.items()}
        self.rays |= {"radius": radius, **bounds}
        return digest([self.rays["origins"], self.rays["directions"]])

    def ask(self, query: str) -> float:
        """Ask the rays; return the seconds."""
        start = self.now()
        self._answer(query)
        return self.now() - start

    def hash(self, query: str) -> str:
        """Ask the rays; return a hash of all columns of the answer."""
        answer = self._answer(query)
        names = ("offsets", "t", "prim", "u", "distance", "t_out")
        parts = [answer] if isinstance(answer, np.ndarray) else [getattr(answer, name, None) for name in names]
        return digest([part for part in parts if part is not None])

    def _answer(self, query: str) -> Any:
        name, more = QUERIES[query]
        return getattr(self.tree, name)(**self.rays, **more)


def unit(vectors: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Scale vectors to length 1."""
    scaled: np.ndarray[Any, Any] = vectors / np.sqrt((vectors**2).sum(axis=1, keepdims=True))
    return scaled


def digest(arrays: list[Any]) -> str:
    """Hash the bytes of arrays."""
    found = hashlib.sha256()
    for each in arrays:
        found.update(np.ascontiguousarray(each).tobytes())
    return found.hexdigest()[:32]


def main() -> None:
    """Take orders until there are no more."""
    worker = Worker()
    for line in sys.stdin:
        order = json.loads(line)
        try:
            told = {"is": getattr(worker, order.pop("do"))(**order)}
        except Exception as error:
            told = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(told), flush=True)


if __name__ == "__main__":
    main()
