"""A run: the mutants of a language that are drawn, what became of each, and the score."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path

from fastlines import InputError

from . import cpp_run, python_run
from .cpp_build import Build
from .cpp_mutants import find_mutants
from .equal import mark_equal
from .mutant import Mutant, draw, score
from .python_sources import MutatedSources, package_folder

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Plan:
    """What to mutate, and how.

    Attributes
    ----------
    checkout : Path
        The repository.
    sample : int or None
        How many mutants are drawn; None for all.
    seed : int
        The same seed draws the same mutants of the same sources.
    seconds : float
        The most time of tests for one mutant.
    n_jobs : int
        How many mutants are tried at the same time.
    work : Path or None
        The folder of the mutated copy, which is kept; a temporary one by default.
    again : frozenset of keys, or None
        Of the drawn mutants, try only these.
    """

    checkout: Path
    sample: int | None = 150
    seed: int = 64
    seconds: float = 60.0
    n_jobs: int = 1
    work: Path | None = None
    again: frozenset[tuple[str | int, ...]] | None = None


@dataclass
class Outcome:
    """The mutants that were tried, and how many of the drawn ones do not compile."""

    language: str
    n_places: int
    n_drawn: int
    mutants: list[Mutant] = field(default_factory=list)

    def to_json(self) -> dict[str, object]:
        """Return all as JSON."""
        head = {"format": "fastlines-bench mutation 1", "language": self.language, "score": score(self.mutants)}
        counts = {"n_places": self.n_places, "n_drawn": self.n_drawn}
        return {**head, **counts, "mutants": [asdict(mutant) for mutant in self.mutants]}


def run_cpp(plan: Plan, progress: Progress, tell: Callable[[str], None]) -> Outcome:
    """Mutate the C++ core, compile it once, and run the tests with each mutant."""
    check_checkout(plan.checkout)
    found = find_mutants(plan.checkout)
    drawn = draw(found, plan.sample, plan.seed)
    with _folder(plan.work) as folder:
        build = Build(plan.checkout, folder)
        kept = [each.mutant for each in build.make(drawn, progress)]
        outcome = Outcome("cpp", len(found), len(drawn), [m for m in kept if plan.again is None or m.key in plan.again])
        cpp_run.run_mutants(build, outcome.mutants, plan.seconds, plan.n_jobs, progress, tell)
    mark_equal(outcome.mutants)
    return outcome


def run_python(plan: Plan, progress: Progress, tell: Callable[[str], None]) -> Outcome:
    """Mutate the installed package as it is imported, and run the tests with each mutant."""
    check_checkout(plan.checkout)
    python_run.check_same(plan.checkout)
    found = MutatedSources(package_folder()).mutants
    drawn = draw(found, plan.sample, plan.seed)
    outcome = Outcome("python", len(found), len(drawn), [m for m in drawn if plan.again is None or m.key in plan.again])
    with _folder(plan.work) as folder:
        python_run.run_mutants(plan.checkout, folder, drawn, outcome.mutants, plan.seconds, plan.n_jobs, progress, tell)
    mark_equal(outcome.mutants)
    return outcome


def check_checkout(path: Path) -> None:
    """Raise an error unless a folder is a checkout of the repository."""
    if not all((path / name).exists() for name in ("cpp/fastlines/core.hpp", "src/fastlines", "tests/conftest.py")):
        raise InputError(
            f"{path} is no checkout of fastlines: mutants are made of its sources, and its tests run; change to a "
            "checkout, or name it by --checkout"
        )


def read_again(path: Path) -> frozenset[tuple[str | int, ...]]:
    """Return the keys of the mutants of an earlier run that no test noticed and that are not known to be equal."""
    try:
        mutants = [Mutant(**each) for each in json.loads(path.read_text(encoding="utf-8"))["mutants"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"--again {path}: expected a file that --json wrote: {error}") from None
    mark_equal(mutants)
    return frozenset(mutant.key for mutant in mutants if mutant.is_undetected)


@contextmanager
def _folder(work: Path | None) -> Iterator[Path]:
    if work is not None:
        work.mkdir(parents=True, exist_ok=True)
        yield work.resolve()
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder).resolve()


def undetected(mutants: Sequence[Mutant]) -> list[Mutant]:
    """Return the mutants that no test noticed and that are not known to be equal."""
    return [mutant for mutant in mutants if mutant.is_undetected]
