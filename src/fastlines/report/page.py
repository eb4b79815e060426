"""The report as one page of HTML that holds all it needs: pictures, style, and a few lines that sort tables."""

from __future__ import annotations

import base64
from html import escape
from importlib import resources
from pathlib import Path

from .document import Cell, Document, Gallery, Picture, Section, Table
from .heat import COLOURS, MOST


def html(document: Document, images: Path) -> str:
    """Write the page; pictures are read from this folder."""
    style = resources.files("fastlines.demo") / "page.css", resources.files(__package__) / "page.css"
    script = (resources.files(__package__) / "page.js").read_text(encoding="utf-8")
    sections = "\n".join(_section(section, images) for section in document.sections)
    links = " · ".join(f'<a href="#{escape(each.name)}">{escape(each.title)}</a>' for each in document.sections)
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>{escape(document.title)}</title>
<style>
{"".join(file.read_text(encoding="utf-8") for file in style)}</style>
</head>
<body>
<main>
<header>
<h1>{escape(document.title)}</h1>
<p class="lead">{escape(document.lead)}</p>
<nav>{links}</nav>
<p class="note hint">A click on the head of a column sorts its table.</p>
</header>
{sections}
<footer><p>{escape(document.foot)}</p></footer>
</main>
<script>
{script}</script>
</body>
</html>
"""


def _section(section: Section, images: Path) -> str:
    text = "".join(f"<p>{escape(each)}</p>" for each in section.text)
    points = "".join(f"<dt>{escape(what)}</dt><dd>{escape(why)}</dd>" for what, why in section.points)
    parts = "\n".join(_table(part) if isinstance(part, Table) else _gallery(part, images) for part in section.parts)
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
    tag = "th" if is_head else "td"
    return f"<{tag}{value}{mark}>{escape(cell.text)}{other}</{tag}>"


def _gallery(gallery: Gallery, images: Path) -> str:
    if not gallery.pictures:
        return ""
    figures = "".join(_figure(picture, images) for picture in gallery.pictures)
    scale = _scale() if gallery.scale else ""
    caption = f'<p class="note">{escape(gallery.caption)} {scale}</p>' if gallery.caption else ""
    return (
        f'{caption}<div class="gallery" style="--columns:{gallery.columns};--least:{gallery.least}px">{figures}</div>'
    )


def _figure(picture: Picture, images: Path) -> str:
    data = base64.b64encode((images / picture.file).read_bytes()).decode()
    return (
        f'<figure><img src="data:image/png;base64,{data}" alt="{escape(picture.alt)}">'
        f"<figcaption>{escape(picture.caption)}</figcaption></figure>"
    )


def _scale() -> str:
    """The colours of the counts, from 1 to `MOST`."""
    stops = ",".join(f"rgb({r:.0f},{g:.0f},{b:.0f})" for r, g, b in COLOURS)
    return f'<span class="scale">1 <i style="background:linear-gradient(to right,{stops})"></i> {MOST:,}</span>'
