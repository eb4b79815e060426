"""A page of sections, tables and pictures, as HTML; its pictures are embedded or in a folder beside it."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib import resources
from pathlib import Path


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


def html(document: Document, images: Path, embed: bool = True) -> str:
    """Return a document as HTML.

    Its pictures are in the folder `images`. They are embedded, or else the page refers to them and must be saved beside
    that folder.
    """
    style, script = ((resources.files(__package__) / name).read_text("utf-8") for name in ("page.css", "page.js"))

    def source(file: str) -> str:
        if not embed:
            return f"{images.name}/{file}"
        return "data:image/png;base64," + base64.b64encode((images / file).read_bytes()).decode()

    sections = "\n".join(_section(section, source) for section in document.sections)
    links = " · ".join(f'<a href="#{escape(each.name)}">{escape(each.title)}</a>' for each in document.sections)
    verdicts = "".join(f"<li><strong>{escape(a)}</strong><span>{escape(b)}</span></li>" for a, b in document.verdicts)
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>{escape(document.title)}</title>
<style>
{style}</style>
</head>
<body>
<main>
<header>
<h1>{escape(document.title)}</h1>
<p class="lead">{escape(document.lead)}</p>
{f'<ul class="verdicts">{verdicts}</ul>' if verdicts else ""}
<nav>{links}</nav>
<p class="note hint">Click the head of a column to sort its table.</p>
</header>
{sections}
<footer><p>{escape(document.foot)}</p></footer>
</main>
<script>
{script}</script>
</body>
</html>
"""


def _section(section: Section, source: Callable[[str], str]) -> str:
    text = "".join(f"<p>{escape(each)}</p>" for each in section.text)
    points = "".join(f"<dt>{escape(what)}</dt><dd>{escape(why)}</dd>" for what, why in section.points)
    parts = "\n".join(_table(part) if isinstance(part, Table) else _gallery(part, source) for part in section.parts)
    listed = f'<dl class="points">{points}</dl>' if points else ""
    return (
        f'<section id="{escape(section.name)}">\n<h2>{escape(section.title)}</h2>\n{text}{listed}\n{parts}\n</section>'
    )


def _table(table: Table) -> str:
    heads = "".join(
        f'<th scope="col" aria-sort="none"><button>{escape(head) or "row"}</button></th>' for head in table.heads
    )
    rows = "".join(f"<tr>{''.join(_cell(cell, i == 0) for i, cell in enumerate(row))}</tr>" for row in table.rows)
    caption = f"<caption>{escape(table.caption)}</caption>" if table.caption else ""
    notes = "".join(f'<p class="note">{escape(note)}</p>' for note in table.notes)
    return (
        f'<div class="scroll" tabindex="0"><table class="sortable">{caption}<thead><tr>{heads}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>{notes}"
    )


def _cell(cell: Cell, is_head: bool) -> str:
    value = "" if cell.value is None else f' data-value="{cell.value!r}"'
    mark = {True: ' class="good"', False: ' class="bad"', None: ""}[cell.good]
    other = f"<small>{escape(cell.other)}</small>" if cell.other else ""
    bar = "" if cell.bar is None else f' class="bar" style="--share:{100 * cell.bar:.0f}%"'
    tag = "th" if is_head else "td"
    return f"<{tag}{value}{mark}{bar}>{escape(cell.text)}{other}</{tag}>"


def _gallery(gallery: Gallery, source: Callable[[str], str]) -> str:
    if not gallery.pictures:
        return ""
    figures = "".join(
        f'<figure><img src="{escape(source(each.file))}" alt="{escape(each.alt)}">'
        f"<figcaption>{escape(each.caption)}</figcaption></figure>"
        for each in gallery.pictures
    )
    scale = _scale(*gallery.scale) if gallery.scale else ""
    caption = f'<p class="note">{escape(gallery.caption)} {scale}</p>' if gallery.caption else ""
    if gallery.mosaic:
        return f'{caption}<div class="mosaic">{figures}</div>'
    return (
        f'{caption}<div class="gallery" style="--columns:{gallery.columns};--least:{gallery.least}px">{figures}</div>'
    )


def _scale(colours: Sequence[Sequence[float]], most: int) -> str:
    """Show the colours of the counts from 1 to `most`."""
    stops = ",".join(f"rgb({r:.0f},{g:.0f},{b:.0f})" for r, g, b in colours)
    return f'<span class="scale">1 <i style="background:linear-gradient(to right,{stops})"></i> {most:,}</span>'
