"""``fastlines-bench thesis``: chapter 6 of the thesis repeated, with its own figures next to ours and its findings."""

from .preset import ThesisPreset
from .run import make_thesis, missing_peer

__all__ = ["ThesisPreset", "make_thesis", "missing_peer"]
