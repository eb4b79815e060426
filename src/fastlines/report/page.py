"""The parts of a page of HTML: sections, galleries of pictures, and tables that a click sorts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from importlib import resources
from typing import NamedTuple


class Section(NamedTuple):
    """A headed part of a page: its anchor, its title and its HTML."""

    name: str
    title: str
    body: str


def page(title: str, lead: str, sections: Sequence[Section], foot: str, verdicts: Iterable[tuple[str, str]]) -> str:
    """Return a whole page; the verdicts are at the top, each a few words with an explanation."""
    style, script = ((resources.files(__package__) / name).read_text("utf-8") for name in ("page.css", "page.js"))
    links = " · ".join(f'<a href="#{escape(name)}">{escape(text)}</a>' for name, text, _ in sections)
    listed = "".join(f"<li><strong>{escape(a)}</strong><span>{escape(b)}</span></li>" for a, b in verdicts)
    body = "\n".join(
        f'<section id="{escape(name)}">\n<h2>{escape(text)}</h2>\n{part}\n</section>' for name, text, part in sections
    )
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>{escape(title)}</title>
<style>
{style}</style>
</head>
<body>
<main>
<header>
<h1>{escape(title)}</h1>
<p class="lead">{escape(lead)}</p>
{f'<ul class="verdicts">{listed}</ul>' if listed else ""}
<nav>{links}</nav>
<p class="note hint">Click the head of a column to sort its table.</p>
</header>
{body}
<footer><p>{escape(foot)}</p></footer>
</main>
<script>
{script}</script>
</body>
</html>
"""


def points(pairs: Iterable[tuple[str, str]]) -> str:
    """Return a list of terms, each with an explanation."""
    listed = "".join(f"<dt>{escape(what)}</dt><dd>{escape(why)}</dd>" for what, why in pairs)
    return f'<dl class="points">{listed}</dl>'


def table(heads: Iterable[str], rows: Iterable[Iterable[str]], caption: str = "", note: str = "") -> str:
    """Return a table with rows of cells."""
    head = "".join(f'<th scope="col" aria-sort="none"><button>{escape(each) or "row"}</button></th>' for each in heads)
    body = "".join(f"<tr>{''.join(row)}</tr>" for row in rows)
    above = f"<caption>{escape(caption)}</caption>" if caption else ""
    below = f'<p class="note">{escape(note)}</p>' if note else ""
    return (
        f'<div class="scroll" tabindex="0"><table class="sortable">{above}<thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>{below}"
    )


def cell(text: str, value: float | None = None, bar: float | None = None, tag: str = "td") -> str:
    """Return a cell, which sorts by its value or else last, with a bar of a length from 0 to 1 behind it."""
    key = "" if value is None else f' data-value="{value!r}"'
    behind = "" if bar is None else f' class="bar" style="--share:{100 * bar:.0f}%"'
    return f"<{tag}{key}{behind}>{escape(text)}</{tag}>"


def gallery(pictures: Iterable[tuple[str, str, str]], columns: int = 0, least: int = 100) -> str:
    """Return pictures, each a source, a caption and an alternative text, in columns of at least `least` pixels.

    Without columns the first picture is twice as large as the others, which are beside it.
    """
    figures = "".join(
        f'<figure><img src="{escape(source)}" alt="{escape(alt)}"><figcaption>{escape(caption)}</figcaption></figure>'
        for source, caption, alt in pictures
    )
    shape = f'"gallery" style="--columns:{columns};--least:{least}px"' if columns else '"mosaic"'
    return f"<div class={shape}>{figures}</div>" if figures else ""
