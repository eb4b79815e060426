"""The errors that fastlines raises, and its warnings: each says what was given, what was expected and what to do."""

from __future__ import annotations


class FastlinesError(Exception):
    """Base of every error that fastlines raises on purpose; the command line prints it as one line."""


class InputError(FastlinesError, ValueError):
    """An argument or an array that cannot be used as it is."""


class FileFormatError(FastlinesError, ValueError):
    """A file whose content is not what its format promises."""


class MissingExtraError(FastlinesError, ImportError):
    """An optional dependency is needed and not installed."""

    def __init__(self, what: str, extra: str) -> None:
        super().__init__(f"{what} needs an optional dependency: run  pip install 'fastlines[{extra}]'")


class PrecisionWarning(UserWarning):
    """Coordinates that float32 cannot tell apart as their scene needs it."""


class FileWarning(UserWarning):
    """A file that was read although something about it is odd, or although it leaves out what had to be assumed."""


class InvalidTreeError(FastlinesError):
    """A tree that breaks an axiom.

    Attributes
    ----------
    node : int
        Which node breaks it.
    axiom : str
        Which axiom: "axiom 1" to "axiom 5", "BVH axiom", "KD axiom" or "Theorem 4"; or "the bound on depth".
    """

    def __init__(self, node: int, axiom: str, detail: str) -> None:
        super().__init__(f"node {node} breaks {axiom}: {detail}")
        self.node = node
        self.axiom = axiom
