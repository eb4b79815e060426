"""How lines are made of the objects of other libraries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .offsets import Offset


@dataclass(frozen=True)
class Making:
    """How lines are made of an object.

    Attributes
    ----------
    invalid, offset
        As in `Lines.from_segments`.
    warn : callable
        Takes what is left out, in words.
    """

    invalid: str
    offset: Offset | str
    warn: Callable[[str], None]

    @property
    def options(self) -> dict[str, Any]:
        """The options of `Lines.from_segments` and its siblings."""
        return {"invalid": self.invalid, "offset": self.offset}
