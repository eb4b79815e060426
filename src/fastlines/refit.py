"""When to build a tree anew rather than to refit it once more."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import number
from .tree_data import TreeData


@dataclass
class RebuildPolicy:
    """Build anew as soon as queries have lost, since the last build, the time that a build takes.

    A query on a refitted tree takes about `Tree.growth` times as long as it would if the cost had not grown; so of the
    time of queries the share 1 − 1/growth is lost. Waiting until the losses add up to one build, losses and builds
    together take at most twice as long as with the best times to build in hindsight, but for the last frame's loss
    (docs/refit.md).

    Parameters
    ----------
    build_seconds : float
        How long a build takes, with the layout.
    lost_seconds : float
        What has been lost since the last build.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree, rule = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]]), RebuildPolicy(build_seconds=1.0)
    >>> tree = tree.refit([[[0, 0, 0], [1, 1, 2]], [[8, 8, 8], [9, 9, 9]]])
    >>> if rule.due(tree, query_seconds=0.5):
    ...     tree = fl.build(tree.geometry)
    """

    build_seconds: float
    lost_seconds: float = 0.0

    def __post_init__(self) -> None:
        what = "a time in seconds, above 0"
        self.build_seconds = number("build_seconds", self.build_seconds, what, 0.0)
        self.lost_seconds = _seconds("lost_seconds", self.lost_seconds)

    def due(self, tree: TreeData, query_seconds: float) -> bool:
        """Count what queries on a tree have lost, and tell whether to build anew now; if so, counting starts again.

        Parameters
        ----------
        tree : Tree
            As the queries found it.
        query_seconds : float
            How long they took.
        """
        query_seconds = _seconds("query_seconds", query_seconds)
        self.lost_seconds += query_seconds * max(0.0, 1 - 1 / tree.growth)
        due = self.lost_seconds >= self.build_seconds
        if due:
            self.lost_seconds = 0.0
        return due


def _seconds(name: str, value: object) -> float:
    return 0.0 if value == 0 else number(name, value, "a time in seconds, 0 or more", 0.0)
