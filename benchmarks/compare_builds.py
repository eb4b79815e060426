"""Two builds of fastlines, asked the same rays in turn: how much faster is the second.

    git worktree add ../before HEAD~1
    pip install --no-deps --target ../installed/before ../before
    pip install --no-deps --target ../installed/after .
    python benchmarks/compare_builds.py ../installed/before ../installed/after
    python benchmarks/compare_builds.py ../installed/before ../installed/after --scene bun-hair --radius 0.001

Each build works in a process of its own, on one thread, with a tree of its own; the lines and rays are those of the
fastlines that runs this. Turns are short, so that both have what the machine gives at the time, and the time that
the processor took counts. Printed is how many times as fast the second build is, by the medians of all turns and by
the best ones. A build beside itself tells how much of that is noise.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import fastlines as fl

if TYPE_CHECKING:  # a build that is compared may have no such modules
    from fastlines.bench.rays import RayBatch

#: So long takes a turn, about, and so many turns has each build.
SECONDS, TURNS = 0.02, 15
#: Queries that are asked besides those of `KINDS`, of a camera's and of random rays.
MORE = ("surface", "next", "count")
PIXELS, OTHERS = 1 << 20, 1 << 18


def answer(tree: Any, query: str, rays: dict[str, Any]) -> Any:
    """Ask the tree of either build."""
    ask = {"first": "first_hit", "surface": "first_hit", "any": "any_hit", "all": "all_hits"}
    ask |= {"next": "next_hits", "count": "count_hits"}
    more: dict[str, dict[str, Any]] = {"surface": {"at": "surface"}, "next": {"k": 3}}
    return getattr(tree, ask[query])(**rays, **more.get(query, {}))


def digest(found: Any) -> str:
    """Name what was answered, bit for bit."""
    columns = ("offsets", "t", "prim", "u", "distance", "t_out")
    parts = [found] if isinstance(found, np.ndarray) else [getattr(found, name, None) for name in columns]
    parts = [part for part in parts if part is not None]
    return hashlib.sha256(b"".join(np.ascontiguousarray(part).tobytes() for part in parts)).hexdigest()


def work() -> None:
    """Take orders from standard input, one a line, and tell what came of them: a build's side of the comparison."""
    print(json.dumps(str(Path(fl.__file__).parents[1])), flush=True)
    fl.set_num_threads(1)
    tree: Any = None
    rays: dict[str, Any] = {}
    for line in sys.stdin:
        order = json.loads(line)
        told: Any = None
        if "lines" in order:
            tree = fl.build(np.load(order["lines"]))
        elif "rays" in order:
            rays = {name: array[()] for name, array in np.load(order["rays"]).items()}
        elif "first" in order:
            told = digest(answer(tree, order["first"], rays))
        else:
            start = time.process_time()
            answer(tree, order["query"], rays)
            told = time.process_time() - start
        print(json.dumps(told), flush=True)


class Build:
    """A process that has imported the fastlines of a folder."""

    def __init__(self, folder: Path) -> None:
        if not (folder / "fastlines").is_dir():
            raise SystemExit(f"{folder} is not what `pip install --target` makes: there is no {folder / 'fastlines'}")
        environment = {**os.environ, "PYTHONPATH": str(folder)}
        command = [sys.executable, __file__, "--work"]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )
        if (imported := self.told()) != str(folder):
            raise SystemExit(
                f"a build of {folder} was asked for, and {imported} was imported: is that an editable one?"
            )

    def do(self, **order: Any) -> Any:
        """Give an order, and wait for what comes of it."""
        assert self.process.stdin
        print(json.dumps(order), file=self.process.stdin, flush=True)
        return self.told()

    def told(self) -> Any:
        """What the process says next."""
        assert self.process.stdout
        told = self.process.stdout.readline()
        if not told:
            raise SystemExit("a build has failed; see above")
        return json.loads(told)


def questions(scene: str, radii: list[float], kinds: list[str]) -> Iterator[tuple[RayBatch, str, float]]:
    """Yield rays, a query and a radius."""
    from fastlines.bench.engine import Case, occlusion
    from fastlines.bench.rays import KINDS, camera_rays, random_rays

    made = fl.scenes.make(scene)
    tree = fl.build(made.lines)
    for radius in radii:
        for kind in kinds:
            if kind == "camera":
                rays = camera_rays(made.camera, PIXELS)
            elif kind == "random":
                rays = random_rays(made.lines, OTHERS)
            else:
                rays = occlusion(Case(scene, made.lines, made.camera), tree, radius, OTHERS)
            for query in (*KINDS[kind], *(() if kind == "ao" else MORE)):
                yield rays, query, radius


def ratios(builds: list[Build], rays: RayBatch, query: str, radius: float, folder: str) -> tuple[float, float, bool]:
    """Ask in turn; return how many times as fast the second is, by medians and by the best turns; and if both agree."""

    def give(part: RayBatch) -> None:
        arrays = {"origins": part.origins, "directions": part.directions, "t_min": part.t_min, "t_max": part.t_max}
        np.savez(f"{folder}/rays.npz", radius=radius, **arrays)  # type: ignore[arg-type]
        for build in builds:
            build.do(rays=f"{folder}/rays.npz")

    few = rays.part(1 << 14)
    give(few)
    slowest = max(build.do(query=query) for build in builds for _ in range(2))
    give(rays.part(int(len(few) * SECONDS / slowest)))
    first, second = (build.do(first=query) for build in builds)
    times: list[list[float]] = [[], []]
    for turn in range(TURNS):
        for i in (0, 1) if turn % 2 else (1, 0):
            times[i].append(builds[i].do(query=query))
    return statistics.median(times[0]) / statistics.median(times[1]), min(times[0]) / min(times[1]), first == second


def main() -> None:
    """Compare, and print a row for each question."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("builds", type=Path, nargs=2)
    parser.add_argument("--scene", default="bun-hair,straight-hair,spaghetti,spaghetti-2,photon-beams")
    parser.add_argument("--radius", default="0.005,0.001,0.0005")
    parser.add_argument("--rays", default="camera,random,ao")
    parser.add_argument("--simd", help="the instruction set of both; the best of the machine unless given")
    given = parser.parse_args()
    scenes, kinds = given.scene.split(","), given.rays.split(",")
    radii = [float(radius) for radius in given.radius.split(",")]
    if given.simd:
        os.environ["FASTLINES_SIMD"] = given.simd
    builds = [Build(folder.resolve()) for folder in given.builds]
    logs: dict[tuple[str, str], list[float]] = {}
    all_same = True
    print(f"{'scene':14} {'radius':>7} {'rays':7} {'query':8} medians   best")
    with tempfile.TemporaryDirectory() as folder:
        for scene in scenes:
            np.save(f"{folder}/lines.npy", fl.scenes.make(scene).lines.segments)
            for build in builds:
                build.do(lines=f"{folder}/lines.npy")
            for rays, query, radius in questions(scene, radii, kinds):
                median, best, same = ratios(builds, rays, query, radius, folder)
                all_same &= same
                logs.setdefault((rays.kind, query), []).append(median)
                print(
                    f"{scene:14} {radius:7g} {rays.kind:7} {query:8} {median:7.3f} {best:6.3f}",
                    "" if same else "answers differ",
                    flush=True,
                )
    for (kind, query), values in logs.items():
        print(f"{'all':22} {kind:7} {query:8} {statistics.geometric_mean(values):7.3f}")
    if not all_same:
        raise SystemExit("answers differ")


if __name__ == "__main__":
    if sys.argv[1:] == ["--work"]:
        work()
    else:
        main()
