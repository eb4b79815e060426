"""``fastlines-bench thesis``: chapter 6 of the thesis made again, its own figures beside ours, its findings checked."""

from .preset import ThesisPreset
from .run import make_thesis, missing_peer

__all__ = ["ThesisPreset", "make_thesis", "missing_peer"]
