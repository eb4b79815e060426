"""What a page says, before it is HTML: sections of text, tables and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Cell:
    """A figure in a table.

    `value` is its key for sorting, and None sorts last. `other` is a second figure below it. `good` marks it as one
    that holds, or does not. `bar` is the length of a bar behind it, from 0 to 1.
    """

    text: str
    value: float | None = None
    other: str = ""
    good: bool | None = None
    bar: float | None = None


@dataclass(frozen=True)
class Table:
    """Rows under heads; the first column names the row."""

    heads: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class Picture:
    """A picture in the folder of images, and what it shows."""

    file: str
    caption: str
    alt: str


@dataclass(frozen=True)
class Gallery:
    """Pictures side by side, in up to `columns` columns, each at least `least` pixels wide.

    `scale` is the colours, (r, g, b), in which the pictures show counts from 1 to its second part. With `mosaic` the
    first picture is twice as large as the others, which stand beside it.
    """

    pictures: Sequence[Picture]
    columns: int
    least: int = 100
    caption: str = field(default="", kw_only=True)
    scale: tuple[Sequence[Sequence[float]], int] | None = field(default=None, kw_only=True)
    mosaic: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class Section:
    """A headed part of the page."""

    name: str
    title: str
    text: Sequence[str] = ()
    parts: Sequence[Table | Gallery] = ()
    points: Sequence[tuple[str, str]] = ()


@dataclass(frozen=True)
class Document:
    """A whole page; its verdicts stand at the top, each a few words with an explanation."""

    title: str
    lead: str
    sections: Sequence[Section]
    foot: str
    verdicts: Sequence[tuple[str, str]] = ()
