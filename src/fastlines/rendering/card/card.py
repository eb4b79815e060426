"""Cards: what notebooks show of geometry, a tree or an answer: a thumbnail and a table of facts, as one piece of HTML.

A card has no scripts and no style sheet, because notebooks remove or share them. Each style stands at its element. Text
and lines take the colour of the page, so that cards suit light and dark themes.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable
from html import escape
from typing import TYPE_CHECKING, Any

from ...query.prim_numbers import PrimNumbers
from ...query.proximity.pairs import Pairs
from ...structure.tree_data import TreeData
from .facts import Fact, geometry_facts, tree_facts
from .hit_facts import hit_facts
from .sketch import Sketch, sketch
from .thumbnail import HEIGHT, WIDTH, draw_sketch, to_png

if TYPE_CHECKING:
    from PIL import Image

#: The width of a thumbnail on the page, in CSS pixels; there are more in the file, for sharp screens.
SHOWN = 240

FACE = "display:flex;flex-wrap:wrap;gap:16px;align-items:flex-start;font-size:13px;line-height:1.45;margin:4px 0"
FRAME = "display:block;border-radius:8px;background:#101218;box-shadow:0 0 0 1px rgba(128,128,128,.3)"
PICTURE = f"{FRAME};width:{SHOWN}px;height:{SHOWN * HEIGHT // WIDTH}px"
EMPTY = f"{PICTURE};color:#9aa;text-align:center;line-height:{SHOWN * HEIGHT // WIDTH}px"
CAPTION = f"max-width:{SHOWN}px;opacity:.65;font-size:11px;margin-top:3px"
NAME = "text-align:left;vertical-align:top;padding:1px 14px 1px 0;border:0;font-weight:normal;opacity:.65"
VALUE = "text-align:left;vertical-align:top;padding:1px 0;border:0;max-width:34em;overflow-wrap:anywhere"


def card(shown: Any) -> str:
    """Return a card of a geometry, a tree, or the answer of a query, which has no picture.

    Examples
    --------
    >>> import fastlines as fl
    >>> html = card(fl.Lines.from_segments([[[0, 0, 0], [1, 2, 3]]]))
    >>> "data:image/png;base64," in html, "<script" in html
    (True, False)
    """
    if isinstance(shown, PrimNumbers | Pairs):
        return _face("", title(shown), hit_facts(shown))
    drawn, image = picture_of(shown)
    if image is None:
        picture = f'<div style="{EMPTY}">nothing to draw</div>'
    else:
        data = base64.b64encode(to_png(image)).decode()
        picture = f'<img style="{PICTURE}" alt="{escape(title(shown))}" src="data:image/png;base64,{data}">'
    caption = f'<div style="{CAPTION}">{escape(drawn.caption)}</div>' if drawn.caption else ""
    facts = tree_facts(shown) if isinstance(shown, TreeData) else geometry_facts(shown)
    return _face(f"<div>{picture}{caption}</div>", title(shown), facts)


def _face(picture: str, name: str, facts: Iterable[Fact]) -> str:
    """Return a picture beside a titled table."""
    head = f'<div style="font-weight:600;margin-bottom:3px">{escape(name)}</div>'
    return f'<div style="{FACE}">{picture}<div>{head}{table(facts)}</div></div>'


def thumbnail(shown: Any) -> bytes | None:
    """Return the picture of a card as PNG; None where there is nothing to draw."""
    if isinstance(shown, PrimNumbers | Pairs):
        return None
    image = picture_of(shown)[1]
    return None if image is None else to_png(image)


def picture_of(shown: Any) -> tuple[Sketch, Image.Image | None]:
    """Return the sample of a geometry or a tree that is drawn, and the picture."""
    tree = shown if isinstance(shown, TreeData) else None
    drawn = sketch(shown if tree is None else tree.geometry)
    return drawn, draw_sketch(drawn, tree)


def title(shown: Any) -> str:
    """Return the name of a kind of object: its class, or what a class of your own is called."""
    return type(getattr(shown, "source", shown)).__name__


def table(facts: Iterable[Fact]) -> str:
    """Return facts as a table in HTML; all text is escaped.

    Examples
    --------
    >>> "&lt;b&gt;" in table([("attributes", "<b>")])
    True
    """
    rows = "".join(
        f'<tr style="background:none"><th scope="row" style="{NAME}">{escape(name)}</th>'
        f'<td style="{VALUE}">{escape(text)}</td></tr>'
        for name, text in facts
    )
    return f'<table style="border-collapse:collapse;border:0;margin:0;font-size:inherit">{rows}</table>'
