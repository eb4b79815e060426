"""What the report says, before it is HTML or Markdown: sections of text, tables and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Cell:
    """A figure in a table.

    Attributes
    ----------
    text : str
    value : float or None
        What it is sorted by; None goes last.
    other : str
        The figure of the thesis that stands with it, or "".
    good : bool or None
        Whether it is marked as one that holds, or does not.
    """

    text: str
    value: float | None = None
    other: str = ""
    good: bool | None = None


@dataclass(frozen=True)
class Table:
    """Rows under heads; the first column names the row."""

    heads: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class Picture:
    """A picture in the folder of steps, and what it shows."""

    file: str
    caption: str
    alt: str


@dataclass(frozen=True)
class Gallery:
    """Pictures side by side, so many if there is room, none narrower than so many pixels."""

    pictures: Sequence[Picture]
    columns: int
    least: int = 100
    caption: str = field(default="", kw_only=True)
    scale: bool = False  # it goes with the scale of colours of the counts


@dataclass(frozen=True)
class Section:
    """A headed part of the report."""

    name: str
    title: str
    text: Sequence[str] = ()
    parts: Sequence[Table | Gallery] = field(default=())
    points: Sequence[tuple[str, str]] = ()


@dataclass(frozen=True)
class Document:
    """All of it."""

    title: str
    lead: str
    sections: Sequence[Section]
    foot: str
