"""Installed copies of fastlines, each in a worker process: hashes of their answers, and their speed compared.

Times of a query differ by 5 to 10 % from one pair of processes to the next, more than within a pair. So each scene and
radius is measured in a new pair, and the ratio of a cell is the median of the ratios of its rounds.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from fastlines import FastlinesError, InputError

from . import worker
from .harness.preset import TimedPreset, sized
from .harness.tables import geometric_mean, new_table, print_table, wide_console

#: The number of segments of the scenes over which trees of all methods are hashed.
SMALL = 2000

#: The trees that are hashed, as arguments of `fastlines.build`.
TREES: dict[str, dict[str, Any]] = {
    "best": {},
    "best, effort 0": {"effort": 0},
    "best, effort 1": {"effort": 1},
    **{method: {"method": method} for method in ("bvh-cl", "bvh-ss", "bvh-d2", "kd-cl", "kd-d2")},
}

#: The number of rays of the trial that sets the number of timed rays, and the maximum of the latter.
TRIAL_RAYS, MAX_RAYS = 1 << 14, 1 << 20

#: Seconds for all builds of one tree by a copy; at least three rounds are run.
BUILD_SECONDS = 2.0


class Copy:
    """A worker process with an installed fastlines.

    Parameters
    ----------
    where : str
        A Python that has fastlines, or a folder that ``pip install --target`` made.
    n_threads : int
    """

    def __init__(self, where: str, n_threads: int = 1) -> None:
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        program = where
        if os.path.isdir(where):
            if not (Path(where) / "fastlines").is_dir():
                raise InputError(f"{where}: holds no fastlines; expected a folder that pip install --target made")
            environment["PYTHONPATH"] = os.path.abspath(where)
            program = sys.executable
        command = [program, "-P", worker.__file__]
        self.where = where
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                env=environment,
                cwd=tempfile.gettempdir(),
            )
        except OSError as error:
            raise InputError(f"{where}: is neither a Python nor a folder of an installed fastlines ({error})") from None
        self.about: dict[str, Any] = self.request("hello", n_threads=n_threads)
        if os.path.isdir(where) and not Path(self.about["folder"]).is_relative_to(Path(where).resolve()):
            raise InputError(
                f"{where}: the worker imported {self.about['folder']} instead; expected a folder without an editable "
                "install"
            )

    def request(self, method: str, /, **arguments: Any) -> Any:
        """Call a method of the worker; return its result."""
        assert self._process.stdin
        assert self._process.stdout
        try:
            print(json.dumps({"method": method, "arguments": arguments}), file=self._process.stdin, flush=True)
            line = self._process.stdout.readline()
        except OSError:
            line = ""
        if not line:
            raise FastlinesError(f"the worker process of {self.where} has ended; its error is above")
        reply = json.loads(line)
        if "error" in reply:
            raise FastlinesError(f"the request {method!r} to the fastlines of {self.where} failed: {reply['error']}")
        return reply["result"]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe:
                pipe.close()


@dataclass(frozen=True, kw_only=True)
class CopiesPreset(TimedPreset):
    """Which queries are run, on which scenes and rays.

    Parameters
    ----------
    scenes : tuple of str
    radii : tuple of float
    kinds, queries : tuple of str
        Keys of `worker.KINDS` and `worker.QUERIES`.
    """

    n_rays: int = sized(1 << 14, 1 << 10)
    rounds: int = sized(15, 3)
    seconds: float = sized(0.02, 0.005)
    scenes: tuple[str, ...] = ("bun-hair", "straight-hair", "spaghetti", "spaghetti-2", "photon-beams")
    radii: tuple[float, ...] = sized((0.005, 0.001, 0.0005), (0.001,))
    kinds: tuple[str, ...] = worker.KINDS
    queries: tuple[str, ...] = tuple(worker.QUERIES)


Progress = Callable[[str, float], None]


def hash_answers(copy: Copy, preset: CopiesPreset, progress: Progress = lambda what, share: None) -> dict[str, str]:
    """Return the hashes, by name, of all lines, trees, rays and answers of a copy."""
    found: dict[str, str] = {}
    for i, scene in enumerate(preset.scenes):
        progress(scene, i / len(preset.scenes))
        copy.request("open", scene=scene, n_segments=SMALL)
        for name, given in TREES.items():
            found[f"{scene}: tree of {name}"] = copy.request("build", **given)["hash"]
        found[f"{scene}: lines"] = copy.request("open", scene=scene)
        found[f"{scene}: the whole tree"] = copy.request("build")["hash"]
        for radius in preset.radii:
            for kind in preset.kinds:
                named = f"{scene}, radius {radius:g}: {kind} rays"
                found[named] = copy.request("make_rays", kind=kind, n_rays=preset.n_rays, radius=radius)
                for query in preset.queries:
                    found[f"{named}, {query}"] = copy.request("hash_answer", query=query)
    return found


def differences(before: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Return the names whose hashes differ or that only one side has."""
    return [name for name in dict.fromkeys([*before, *now]) if before.get(name) != now.get(name)]


@dataclass(frozen=True)
class Contest:
    """One cell: a query or a build that both copies ran alternately.

    Attributes
    ----------
    radius : float or None
        The radius of the query; None for a build.
    kind, what : str
        The kind of rays and the query; or "build" or "layout", and the tree.
    ratio : float
        The speed-up of the new copy: the median over the rounds of old seconds by new seconds.
    best : float
        The least old seconds by the least new seconds of all rounds.
    same : bool
        Whether the answers of both copies are the same, bit for bit.
    """

    scene: str
    radius: float | None
    kind: str
    what: str
    ratio: float
    best: float
    same: bool


@dataclass(frozen=True)
class Comparison:
    """Two copies, and all cells in which they were compared."""

    machine: dict[str, Any]
    preset: CopiesPreset
    old: dict[str, Any]
    new: dict[str, Any]
    contests: list[Contest]

    def ratios(self) -> dict[tuple[str, str], list[float]]:
        """Return the ratios of all scenes and radii, by `kind` and `what`."""
        found: dict[tuple[str, str], list[float]] = {}
        for each in self.contests:
            found.setdefault((each.kind, each.what), []).append(each.ratio)
        return found

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        means = [
            {"kind": kind, "what": what, "ratio": geometric_mean(ratios)}
            for (kind, what), ratios in self.ratios().items()
        ]
        return {"format": "fastlines-bench compare 2", **asdict(self), "means": means}


def compare_copies(
    old: str, new: str, preset: CopiesPreset, machine: dict[str, Any], progress: Progress = lambda what, share: None
) -> Comparison:
    """Compare two copies, which alternate builds and queries on the same rays.

    Both worker processes are started again for the builds of each scene, and for each scene and radius.

    Parameters
    ----------
    old, new : str
        Where the copies are, as for `Copy`.
    preset : CopiesPreset
        Each copy has `rounds` rounds of about `seconds` for each query.
    machine : dict
        The machine of the measurement, for the result.
    progress : callable
        Called with the current work and the share of all work that is done.
    """
    about: tuple[dict[str, Any], dict[str, Any]] = {}, {}
    contests: list[Contest] = []
    cells = [(scene, radius) for scene in preset.scenes for radius in (None, *preset.radii)]
    for i, (scene, radius) in enumerate(cells):
        progress(f"{scene}: building", i / len(cells))
        with Copy(old, preset.n_threads) as before, Copy(new, preset.n_threads) as now:
            about = before.about, now.about
            if before.request("open", scene=scene) != now.request("open", scene=scene):
                raise FastlinesError(f"{scene}: the scene's lines differ between {old} and {new}")
            if radius is None:
                contests += _builds((before, now), scene, preset.rounds)
                continue
            for kind in preset.kinds:
                for query in preset.queries:
                    progress(f"{scene}, radius {radius:g}: {kind} rays, {query}", i / len(cells))
                    contests.append(_query((before, now), preset, scene, radius, kind, query))
    return Comparison(machine, preset, *about, contests)


def alternate(copies: Sequence[Copy], rounds: int, call: Callable[[Copy], Any]) -> Iterator[tuple[Any, ...]]:
    """Yield the results of all copies, round by round; the copy that goes first changes each round."""
    for i in range(rounds):
        order = copies if i % 2 else copies[::-1]
        results = {id(copy): call(copy) for copy in order}
        yield tuple(results[id(copy)] for copy in copies)


def contest_of(
    scene: str, radius: float | None, kind: str, what: str, times: Sequence[tuple[float, float]], same: bool
) -> Contest:
    """Return the cell of some rounds, given the seconds of the old and the new copy in each of them."""
    pairs = [(max(old, 1e-9), max(new, 1e-9)) for old, new in times]
    least_old, least_new = (min(side) for side in zip(*pairs, strict=True))
    ratio = statistics.median(old / new for old, new in pairs)
    return Contest(scene, radius, kind, what, ratio, least_old / least_new, same)


def _builds(copies: tuple[Copy, Copy], scene: str, max_rounds: int) -> Iterator[Contest]:
    """Yield the cells of some trees and their layouts; slow builds have fewer rounds."""
    for name in ("best", "best, effort 0", "bvh-cl"):
        trial = copies[0].request("build", **TREES[name])
        rounds = int(min(max_rounds, max(3, BUILD_SECONDS / trial["build"])))
        results = list(alternate(copies, rounds, lambda copy, name=name: copy.request("build", **TREES[name])))  # type: ignore[misc]
        same = all(old["hash"] == new["hash"] for old, new in results)
        for kind in ("build", "layout"):
            yield contest_of(scene, None, kind, name, [(old[kind], new[kind]) for old, new in results], same)


def _query(
    copies: tuple[Copy, Copy], preset: CopiesPreset, scene: str, radius: float, kind: str, query: str
) -> Contest:
    def make_rays(n_rays: int) -> bool:
        return len({copy.request("make_rays", kind=kind, n_rays=n_rays, radius=radius) for copy in copies}) == 1

    # Time a trial.
    make_rays(TRIAL_RAYS)
    slowest = max(copy.request("time_query", query=query) for copy in copies for _ in range(2))

    # Choose the number of rays, and compare the answers.
    same = make_rays(min(MAX_RAYS, max(64, int(TRIAL_RAYS * preset.seconds / max(slowest, 1e-9)))))
    same &= len({copy.request("hash_answer", query=query) for copy in copies}) == 1

    # Alternate.
    times = [
        (old, new)
        for old, new in alternate(copies, preset.rounds, lambda copy: copy.request("time_query", query=query))
    ]
    return contest_of(scene, radius, kind, query, times, same)


def print_comparison(found: Comparison) -> None:
    """Print the ratios of each query and build, over all scenes and radii, and the cells whose answers differ."""
    console = wide_console()
    table = new_table("speed-up of the new copy", ["what", "of"], ["mean", "least", "most", "cells"])
    for (kind, what), ratios in found.ratios().items():
        mean = geometric_mean(ratios) or 0.0
        table.add_row(kind, what, *(f"{ratio:.3f}" for ratio in (mean, min(ratios), max(ratios))), f"{len(ratios)}")
    print_table(console, table)
    every = geometric_mean([each.ratio for each in found.contests if each.radius is not None]) or 0.0
    differ = [each for each in found.contests if not each.same]
    for each in differ:
        at = "" if each.radius is None else f", radius {each.radius:g}"
        console.print(f"[red]answers differ[/]: {each.scene}{at}: {each.kind}, {each.what}", highlight=False)
    console.print(
        f"old: fastlines {found.old['version']} ({found.old['folder']}); new: {found.new['version']} "
        f"({found.new['folder']}); {found.new['simd']}. A cell is the median of old / new seconds over up to "
        f"{found.preset.rounds} alternated rounds, {found.preset.n_threads} thread(s). Both processes are started "
        f"again for each scene and radius. mean: geometric, over {len(found.preset.scenes)} scenes and "
        f"{len(found.preset.radii)} radii. All queries together: {every:.3f}. "
        + ("" if differ else "All answers and trees are the same, bit for bit."),
        highlight=False,
    )
