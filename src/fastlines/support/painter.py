"""What draws objects in notebooks.

Pictures are drawn with trees and cameras, which stand above the objects that show themselves. So the front door of the
package names the module that draws, and the first notebook that asks imports it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Painter(Protocol):
    """What draws objects."""

    def card(self, shown: object) -> str:
        """Return a card of an object in HTML: its picture, and a table of facts."""

    def thumbnail(self, shown: object) -> bytes | None:
        """Return a picture of an object as PNG; None where there is nothing to draw."""


_load: Callable[[], Painter] | None = None


def draw_with(load: Callable[[], Painter]) -> None:
    """Choose what draws objects; `load` is called for each picture, and may import it."""
    global _load
    _load = load


def painter() -> Painter | None:
    """Return what draws objects, if anything does."""
    return None if _load is None else _load()
