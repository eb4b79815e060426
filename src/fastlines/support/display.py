"""How objects show themselves in notebooks.

Pictures are drawn with trees and cameras, which stand above the objects that show themselves. So this module knows no
picture: the front door of the package names the module that draws, and the first notebook that asks imports it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from .immutable import Immutable


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


class Shown(Immutable):
    """Base of immutable dataclasses that notebooks show as a card, and other front ends as a picture.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.Lines.from_segments([[[0, 0, 0], [1, 2, 3]]])
    >>> lines._repr_html_()[:4], lines._repr_png_()[1:4]
    ('<div', b'PNG')
    """

    def _repr_html_(self) -> str | None:
        return None if _load is None else _load().card(self)

    def _repr_png_(self) -> bytes | None:
        return None if _load is None else _load().thumbnail(self)
