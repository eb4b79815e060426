"""The report as sections of text, tables and pictures, and its conversion to HTML."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from ..harness.internals import page


@dataclass(frozen=True)
class Cell:
    """A cell of a table.

    `value` is its sort key; None sorts last. `other` is a second figure below the first. `good` marks a figure that
    holds or does not hold.
    """

    text: str
    value: float | None = None
    other: str = ""
    good: bool | None = None


@dataclass(frozen=True)
class Table:
    """A table with a row of heads; the first column names the rows."""

    heads: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class Picture:
    """A picture in the folder of images, with a caption and a description."""

    file: str
    caption: str
    alt: str


@dataclass(frozen=True)
class Gallery:
    """Pictures side by side, in up to `columns` columns, each at least `least` pixels wide.

    `scale` holds the colours, (r, g, b), of counts in the pictures, and the largest count; the least is 1.
    """

    pictures: Sequence[Picture]
    columns: int
    least: int = 100
    caption: str = field(default="", kw_only=True)
    scale: tuple[Sequence[Sequence[float]], int] | None = field(default=None, kw_only=True)


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
    """A whole page. Its verdicts are at the top: a few words each, with an explanation."""

    title: str
    lead: str
    sections: Sequence[Section]
    foot: str
    verdicts: Sequence[tuple[str, str]] = ()


def html(document: Document, images: Path) -> str:
    """Return a document as an HTML page that embeds the pictures of a folder."""
    sections = [
        page.Section(
            section.name,
            section.title,
            "".join(f"<p>{escape(text)}</p>" for text in section.text)
            + (page.points(section.points) if section.points else "")
            + "\n".join(_table(part) if isinstance(part, Table) else _gallery(part, images) for part in section.parts),
        )
        for section in document.sections
    ]
    return page.page(document.title, document.lead, sections, document.foot, document.verdicts)


def _table(table: Table) -> str:
    rows = [[_cell(cell, "td" if i else "th") for i, cell in enumerate(row)] for row in table.rows]
    notes = "".join(f'<p class="note">{escape(note)}</p>' for note in table.notes)
    return page.table(table.heads, rows, table.caption) + notes


def _cell(cell: Cell, tag: str) -> str:
    value = "" if cell.value is None else f' data-value="{cell.value!r}"'
    mark = {True: ' class="good"', False: ' class="bad"', None: ""}[cell.good]
    other = f"<small>{escape(cell.other)}</small>" if cell.other else ""
    return f"<{tag}{value}{mark}>{escape(cell.text)}{other}</{tag}>"


def _gallery(gallery: Gallery, images: Path) -> str:
    def source(file: str) -> str:
        return "data:image/png;base64," + base64.b64encode((images / file).read_bytes()).decode()

    pictures = [(source(each.file), each.caption, each.alt) for each in gallery.pictures]
    scale = _scale(*gallery.scale) if gallery.scale else ""
    caption = f'<p class="note">{escape(gallery.caption)} {scale}</p>' if gallery.caption and pictures else ""
    return caption + page.gallery(pictures, gallery.columns, gallery.least)


def _scale(colours: Sequence[Sequence[float]], most: int) -> str:
    """Return a legend of the colours of counts from 1 to `most`."""
    stops = ",".join(f"rgb({r:.0f},{g:.0f},{b:.0f})" for r, g, b in colours)
    return f'<span class="scale">1 <i style="background:linear-gradient(to right,{stops})"></i> {most:,}</span>'
