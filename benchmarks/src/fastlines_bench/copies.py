"""Installed copies of fastlines, each in a process of its own: their answers, and their speed in turn."""

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

#: The scenes that trees of all methods are hashed over have so many segments.
SMALL = 2000

#: The trees that are hashed, as arguments of `fastlines.build`.
TREES: dict[str, dict[str, Any]] = {
    "best": {},
    "best, effort 0": {"effort": 0},
    "best, effort 1": {"effort": 1},
    **{method: {"method": method} for method in ("bvh-cl", "bvh-ss", "bvh-d2", "kd-cl", "kd-d2")},
}

#: A trial of so many rays tells how many there is time for; no more than `MOST` are asked.
TRIAL, MOST = 1 << 14, 1 << 20

#: All builds of one tree take about so many seconds, where three turns do not take longer.
SLOW = 2.0


class Copy:
    """A process with an installed fastlines.

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
            raise InputError(f"{where}: is no Python and no folder of an installed fastlines ({error})") from None
        self.about: dict[str, Any] = self.do("hello", n_threads=n_threads)
        if os.path.isdir(where) and not Path(self.about["folder"]).is_relative_to(Path(where).resolve()):
            raise InputError(f"{where}: was asked for, and {self.about['folder']} was imported; is it an editable one?")

    def do(self, name: str, **given: Any) -> Any:
        """Give an order, and return what comes of it."""
        assert self._process.stdin
        assert self._process.stdout
        try:
            print(json.dumps({"do": name, **given}), file=self._process.stdin, flush=True)
            line = self._process.stdout.readline()
        except OSError:
            line = ""
        if not line:
            raise FastlinesError(f"the fastlines of {self.where} has ended; its error is above")
        told = json.loads(line)
        if "error" in told:
            raise FastlinesError(f"the fastlines of {self.where}, asked to {name}: {told['error']}")
        return told["is"]

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
    """What copies are asked.

    Parameters
    ----------
    scenes : tuple of str
    radii : tuple of float
    kinds, queries : tuple of str
        Of `worker.KINDS` and `worker.QUERIES`.
    """

    n_rays: int = sized(1 << 14, 1 << 10)
    rounds: int = sized(15, 3)
    seconds: float = sized(0.02, 0.005)
    scenes: tuple[str, ...] = ("bun-hair", "straight-hair", "spaghetti", "spaghetti-2", "photon-beams")
    radii: tuple[float, ...] = sized((0.005, 0.001, 0.0005), (0.001,))
    kinds: tuple[str, ...] = worker.KINDS
    queries: tuple[str, ...] = tuple(worker.QUERIES)


Say = Callable[[str, float], None]


def hash_answers(copy: Copy, preset: CopiesPreset, progress: Say = lambda what, share: None) -> dict[str, str]:
    """Hash all trees and all answers of a copy, and what they are made from; by name."""
    found: dict[str, str] = {}
    for i, scene in enumerate(preset.scenes):
        progress(scene, i / len(preset.scenes))
        copy.do("open", scene=scene, n_segments=SMALL)
        for name, given in TREES.items():
            found[f"{scene}: tree of {name}"] = copy.do("build", **given)["hash"]
        found[f"{scene}: lines"] = copy.do("open", scene=scene)
        found[f"{scene}: the whole tree"] = copy.do("build")["hash"]
        for radius in preset.radii:
            for kind in preset.kinds:
                named = f"{scene}, radius {radius:g}: {kind} rays"
                found[named] = copy.do("make_rays", kind=kind, n_rays=preset.n_rays, radius=radius)
                for query in preset.queries:
                    found[f"{named}, {query}"] = copy.do("hash", query=query)
    return found


def differences(before: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Name what differs, or is only on one side."""
    return [name for name in dict.fromkeys([*before, *now]) if before.get(name) != now.get(name)]


@dataclass(frozen=True)
class Contest:
    """One thing that both copies did in turn.

    Attributes
    ----------
    kind, what : str
        The kind of rays and the query; "build" or "layout", and of which tree.
    ratio, best : float
        How many times as fast the new copy is: by the medians of all turns, and by the best ones.
    same : bool
        Whether both answered alike, bit for bit.
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
    """Two copies, and all that they did in turn."""

    machine: dict[str, Any]
    preset: CopiesPreset
    old: dict[str, Any]
    new: dict[str, Any]
    contests: list[Contest]

    def means(self) -> dict[tuple[str, str], list[float]]:
        """The ratios of all scenes and radii, by kind and query."""
        found: dict[tuple[str, str], list[float]] = {}
        for each in self.contests:
            found.setdefault((each.kind, each.what), []).append(each.ratio)
        return found

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        means = [
            {"kind": kind, "what": what, "ratio": geometric_mean(ratios)}
            for (kind, what), ratios in self.means().items()
        ]
        return {"format": "fastlines-bench compare 1", **asdict(self), "means": means}


def compare_copies(
    old: Copy, new: Copy, preset: CopiesPreset, machine: dict[str, Any], progress: Say = lambda what, share: None
) -> Comparison:
    """Let two copies build, and ask the same rays, in turn.

    Parameters
    ----------
    old, new : Copy
    preset : CopiesPreset
        Turns take about `seconds`, and each copy has `rounds` of them.
    machine : dict
        Where it is measured.
    progress : callable
        Called with what is being done, and which share of all is done.
    """
    contests: list[Contest] = []
    for i, scene in enumerate(preset.scenes):
        progress(f"{scene}: building", i / len(preset.scenes))
        if len({copy.do("open", scene=scene) for copy in (old, new)}) > 1:
            raise FastlinesError(f"{scene}: the scene's lines differ between {old.where} and {new.where}")
        contests += _builds(old, new, scene, preset.rounds)
        for radius in preset.radii:
            for kind in preset.kinds:
                for query in preset.queries:
                    progress(f"{scene}, radius {radius:g}: {kind} rays, {query}", i / len(preset.scenes))
                    contests.append(_queries(old, new, preset, scene, radius, kind, query))
    return Comparison(machine, preset, old.about, new.about, contests)


def in_turn(copies: Sequence[Copy], rounds: int, do: Callable[[Copy], Any]) -> Iterator[tuple[Any, ...]]:
    """Let copies do something in turn, round by round; each begins every other round."""
    for i in range(rounds):
        order = copies if i % 2 else copies[::-1]
        told = {id(copy): do(copy) for copy in order}
        yield tuple(told[id(copy)] for copy in copies)


def _contest(
    scene: str, radius: float | None, kind: str, what: str, times: list[tuple[float, float]], same: bool
) -> Contest:
    old, new = ([max(seconds, 1e-9) for seconds in side] for side in zip(*times, strict=True))
    return Contest(
        scene, radius, kind, what, statistics.median(old) / statistics.median(new), min(old) / min(new), same
    )


def _builds(old: Copy, new: Copy, scene: str, rounds: int) -> Iterator[Contest]:
    """Build trees in turn; slow ones fewer times."""
    for name in ("best", "best, effort 0", "bvh-cl"):
        first = old.do("build", **TREES[name])
        n_turns = int(min(rounds, max(3, SLOW / first["build"])))
        told = list(in_turn((old, new), n_turns, lambda copy, name=name: copy.do("build", **TREES[name])))  # type: ignore[misc]
        same = all(a["hash"] == b["hash"] for a, b in told)
        for kind in ("build", "layout"):
            yield _contest(scene, None, kind, name, [(a[kind], b[kind]) for a, b in told], same)


def _queries(old: Copy, new: Copy, preset: CopiesPreset, scene: str, radius: float, kind: str, query: str) -> Contest:
    copies = old, new

    def rays(n_rays: int) -> bool:
        return len({copy.do("make_rays", kind=kind, n_rays=n_rays, radius=radius) for copy in copies}) == 1

    # Try a few, then as many as there is time for.
    rays(TRIAL)
    slowest = max(copy.do("ask", query=query) for copy in copies for _ in range(2))
    same = rays(min(MOST, max(64, int(TRIAL * preset.seconds / max(slowest, 1e-9)))))
    same &= len({copy.do("hash", query=query) for copy in copies}) == 1
    times = list(in_turn(copies, preset.rounds, lambda copy: copy.do("ask", query=query)))
    return _contest(scene, radius, kind, query, [(a, b) for a, b in times], same)


def print_comparison(found: Comparison) -> None:
    """Print the means over scenes and radii, the least of each, and where answers differ."""
    console = wide_console()
    table = new_table("how many times as fast the new copy is", ["what", "of"], ["mean", "least", "most", "cells"])
    for (kind, what), ratios in found.means().items():
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
        f"({found.new['folder']}); {found.new['simd']}. Geometric means over {len(found.preset.scenes)} scenes and "
        f"{len(found.preset.radii)} radii, of the medians of {found.preset.rounds} turns each, in turn, "
        f"{found.preset.n_threads} thread(s). All queries together: {every:.3f}. "
        + ("" if differ else "All answers and trees are the same, bit for bit."),
        highlight=False,
    )
