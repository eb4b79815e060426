"""The errors that fastlines raises, and its warnings: each says what was given, what was expected and what to do."""

from __future__ import annotations

import re


class FastlinesError(Exception):
    """Base of every error that fastlines raises on purpose; the command line prints it as one line."""


class InputError(FastlinesError, ValueError):
    """An argument or an array that cannot be used as it is."""


class FileFormatError(FastlinesError, ValueError):
    """A file whose content does not follow its format."""


class MissingExtraError(FastlinesError, ImportError):
    """An optional dependency is needed and not installed; the message names it and its extra."""

    def __init__(self, what: str, extra: str) -> None:
        super().__init__(f"{what} needs the extra {extra!r}: run  pip install {requirements_of(extra)}")


def requirements_of(extra: str) -> str:
    """Return what `pip install` takes for an extra of this package: its packages, which any folder can install."""
    from importlib.metadata import PackageNotFoundError, requires

    try:
        lines = requires("fastlines") or []
    except PackageNotFoundError:  # sources that are not installed
        lines = []
    wanted = [line.partition(";")[0].strip() for line in lines if re.search(rf"extra == .{re.escape(extra)}\W", line)]
    return " ".join(f"'{package}'" for package in wanted) or f"'.[{extra}]'  in the folder of fastlines"


class WorkerError(FastlinesError, RuntimeError):
    """A query that other processes were to answer, and could not: the message names the worker or the scheduler."""


class PrecisionWarning(UserWarning):
    """Geometry that is noticeably less exact than what was given.

    Either float32 rounds coordinates that are far from zero for the size of their scene, or curves are cut into as many
    pieces as they may have and are still off by more than their tolerance.
    """


class FileWarning(UserWarning):
    """A file, or an object of another library, that was read although it has an oddity.

    Something missing in it had to be assumed, or something in it is left out.
    """


class QueryWarning(UserWarning):
    """A query with an argument that does not count for what it asks, such as a radius for triangles alone."""


class InvalidTreeError(FastlinesError):
    """A tree that breaks an axiom.

    Attributes
    ----------
    node : int
        The index of the node.
    axiom : str
        "axiom 1" to "axiom 5", "BVH axiom", "KD axiom" or "Theorem 4"; or "the bound on depth".
    """

    def __init__(self, node: int, axiom: str, detail: str) -> None:
        super().__init__(f"node {node} breaks {axiom}: {detail}")
        self.node = node
        self.axiom = axiom
