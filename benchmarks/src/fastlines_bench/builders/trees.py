"""The trees of all builders over one subject: alternated builds within a time limit, and alternated queries."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median

from fastlines import Lines, Tree, build, get_num_threads

from ..harness.clock import clock
from ..harness.rays import QUESTIONS
from ..harness.subjects import Subject
from ..harness.turns import Timings, alternate, query_function
from .names import BUILDERS


class _OverLimitError(Exception):
    """Aborts a build that exceeds the limit."""


@dataclass(frozen=True)
class TimedTree:
    """A builder's tree, and the seconds of each build."""

    tree: Tree
    seconds: list[float]

    @property
    def build_s(self) -> float:
        """The median seconds of a build."""
        return median(self.seconds)


def alternate_builds(
    lines: Lines,
    builders: Sequence[str],
    rounds: int,
    limit: float,
    say: Callable[[str], None] = lambda what: None,
    peer: Callable[[], object] = lambda: None,
) -> dict[str, TimedTree | None]:
    """Build all trees, round by round, with the current number of threads.

    Parameters
    ----------
    lines : Lines
    builders : sequence of str
        Names of `BUILDERS`.
    rounds : int
        The maximum number of builds of each tree.
    limit : float
        Seconds for all builds of a tree, by the clock that times them. A build that takes longer is aborted. A tree is
        not built again if that would likely exceed the limit.
    say : callable
        Called with the current work.
    peer : callable
        Called at the end of each round.

    Returns
    -------
    dict of str to TimedTree or None
        By builder; None for a build that exceeded the limit.
    """
    found: dict[str, TimedTree | None] = {}
    for i in range(rounds):
        for name in builders:
            before = found.get(name)
            if i > 0 and (before is None or sum(before.seconds) * (1 + 1 / len(before.seconds)) > limit):
                continue
            say(f"building {name}")
            built = _build(lines, name, limit)
            if before is None:
                found[name] = built
            elif built is not None:
                before.seconds.extend(built.seconds)
        peer()
    return found


def _build(lines: Lines, name: str, limit: float) -> TimedTree | None:
    now = clock(get_num_threads())
    start = now()

    def watch(share: float) -> None:
        if now() - start > limit:
            raise _OverLimitError

    try:
        tree = build(lines, **BUILDERS[name], progress=watch)
    except _OverLimitError:
        return None
    return TimedTree(tree, [now() - start])


def time_layout(tree: Tree) -> float:
    """Make the layout of a tree; return the seconds that this took."""
    now = clock(get_num_threads())
    start = now()
    assert len(tree.layout.nodes)
    return now() - start


def alternate_queries(
    subject: Subject,
    trees: dict[str, Tree],
    n_rays: int,
    seconds: float,
    rounds: int,
    say: Callable[[str], None] = lambda what: None,
) -> dict[str, Timings]:
    """Alternate the queries of all trees, whose layouts exist; return the timings by question, such as "camera first".

    The arguments are those of `alternate`.
    """
    n_threads = get_num_threads()
    rays = {kind: subject.rays(kind, n_rays) for kind, _ in QUESTIONS}
    found = {}
    for kind, query in QUESTIONS:
        say(f"{kind} rays, {query}")
        variants = {name: query_function(tree, query, subject.middle_radius, n_threads) for name, tree in trees.items()}
        found[f"{kind} {query}"] = alternate(variants, query, rays[kind], seconds, rounds, clock(n_threads))
    return found
