"""How objects show themselves in notebooks."""

from __future__ import annotations

from .painter import painter


class Shown:
    """Base of what notebooks show as a card, and other front ends as a picture if there is one.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.Lines.from_segments([[[0, 0, 0], [1, 2, 3]]])
    >>> lines._repr_html_()[:4], lines._repr_png_()[1:4]
    ('<div', b'PNG')
    """

    def _repr_html_(self) -> str | None:
        return None if (found := painter()) is None else found.card(self)

    def _repr_png_(self) -> bytes | None:
        return None if (found := painter()) is None else found.thumbnail(self)
