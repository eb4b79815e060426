"""The trees of all builders over one subject: built in turn, within a limit of time, and asked in turn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median

from fastlines import Lines, Tree, build, get_num_threads

from ..harness.clock import clock
from ..harness.rays import QUESTIONS
from ..harness.subjects import Subject
from ..harness.turns import Turns, alternate, way
from .names import BUILDERS


class _OverLimitError(Exception):
    """Ends a build that takes too long."""


@dataclass(frozen=True)
class Grown:
    """A builder's tree, and what building it took each time."""

    tree: Tree
    seconds: list[float]

    @property
    def build_s(self) -> float:
        """The median of all builds, in seconds."""
        return median(self.seconds)


def build_in_turn(
    lines: Lines,
    builders: Sequence[str],
    rounds: int,
    limit: float,
    say: Callable[[str], None] = lambda what: None,
    peer: Callable[[], object] = lambda: None,
) -> dict[str, Grown | None]:
    """Build all trees in turn, round by round, with the number of threads that is set.

    Parameters
    ----------
    lines : Lines
    builders : sequence of str
        Names of `BUILDERS`.
    rounds : int
        So often is each tree built, if there is time for it.
    limit : float
        Seconds, of the clock that times the builds. A build that takes longer is ended, and none is begun again for
        which there would not be time within it.
    say : callable
        Called with what is being built.
    peer : callable
        Called once a round: what else takes its turn.

    Returns
    -------
    dict of str to Grown or None
        By builder; None for one that did not end within the limit.
    """
    found: dict[str, Grown | None] = {}
    for i in range(rounds):
        for name in builders:
            before = found.get(name)
            if i > 0 and (before is None or sum(before.seconds) * (1 + 1 / len(before.seconds)) > limit):
                continue
            say(f"building {name}")
            again = _build(lines, name, limit)
            if before is None:
                found[name] = again
            elif again is not None:
                before.seconds.extend(again.seconds)
        peer()
    return found


def _build(lines: Lines, name: str, limit: float) -> Grown | None:
    now = clock(get_num_threads())
    start = now()

    def watch(share: float) -> None:
        if now() - start > limit:
            raise _OverLimitError

    try:
        tree = build(lines, **BUILDERS[name], progress=watch)
    except _OverLimitError:
        return None
    return Grown(tree, [now() - start])


def lay_out(tree: Tree) -> float:
    """Make what queries run on; tell how long that took."""
    now = clock(get_num_threads())
    start = now()
    assert len(tree.layout.nodes)
    return now() - start


def ask_in_turn(
    subject: Subject,
    trees: dict[str, Tree],
    n_rays: int,
    seconds: float,
    rounds: int,
    say: Callable[[str], None] = lambda what: None,
    kernel: str = "auto",
    questions: Sequence[tuple[str, str]] = QUESTIONS,
) -> dict[str, Turns]:
    """Ask all trees, which are laid out, the same questions in turn: "camera first" and so on; see `alternate`."""
    n_threads = get_num_threads()
    rays = {kind: subject.rays(kind, n_rays) for kind, _ in questions}
    found = {}
    for kind, query in questions:
        say(f"{kind} rays, {query}")
        ways = {name: way(tree, query, subject.middle_radius, n_threads, kernel) for name, tree in trees.items()}
        found[f"{kind} {query}"] = alternate(ways, query, rays[kind], seconds, rounds, clock(n_threads))
    return found
