"""Tables and legends as HTML, for the panel and for exported pages. All texts are escaped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from ..rendering.color.tone import srgb
from ..support.texts import number_text
from .line_colors import LineLegend

#: The style of all that the viewer writes, once a page.
STYLE = (
    "<style>"
    ".fl{font-size:11.5px;line-height:1.45;padding:2px 10px}"
    ".fl table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}"
    ".fl th{font-weight:600;text-align:right;opacity:.65;padding:1px 3px;border-bottom:1px solid #8886}"
    ".fl td{text-align:right;padding:1px 3px;white-space:nowrap}"
    ".fl td:first-child,.fl th:first-child{text-align:left}"
    ".fl h4{margin:6px 0 2px;font-size:12px}"
    ".fl p{margin:2px 0}"
    ".fl .note{opacity:.65}"
    ".fl .error{color:#ff8a65}"
    ".fl .wide{overflow-x:auto}"
    ".fl .bar{height:12px;border-radius:2px;margin:2px 0}"
    ".fl .ends{display:flex;justify-content:space-between}"
    "</style>"
)


@dataclass(frozen=True)
class Table:
    """Texts in rows and columns."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]

    def html(self) -> str:
        """Return the table as HTML.

        Examples
        --------
        >>> Table(["a<b"], [["1"]]).html()
        '<div class="wide"><table><tr><th>a&lt;b</th></tr><tr><td>1</td></tr></table></div>'
        """
        lines = [("th", self.header), *(("td", row) for row in self.rows)]
        rows = ("".join(f"<{tag}>{escape(text)}</{tag}>" for text in texts) for tag, texts in lines)
        return f'<div class="wide"><table>{"".join(f"<tr>{row}</tr>" for row in rows)}</table></div>'


def paragraph(text: str, kind: str = "") -> str:
    """Return a paragraph as HTML; kinds are "note" and "error"."""
    return f'<p class="{kind}">{escape(text)}</p>' if text else ""


def heading(text: str) -> str:
    """Return a heading as HTML."""
    return f"<h4>{escape(text)}</h4>"


def block(*parts: str) -> str:
    """Return parts in a block, to which the style applies."""
    return f'<div class="fl">{"".join(parts)}</div>'


def legend_html(legend: LineLegend) -> str:
    """Return a legend as HTML: its title, the colours with the numbers at both ends, and notes.

    Examples
    --------
    >>> legend_html(LineLegend("direction"))
    '<h4>direction</h4>'
    """
    parts = [heading(legend.title)]
    if (bar := legend.bar) is not None:
        colors = np.rint(255 * srgb(bar.colors(np.linspace(bar.low, bar.high, 16)))).astype(int).tolist()
        stops = ",".join(f"rgb({red},{green},{blue})" for red, green, blue in colors)
        parts.append(f'<div class="bar" style="background:linear-gradient(to right,{stops})"></div>')
        ends = [number_text(bar.low)] + [number_text(bar.high)] * (not bar.is_constant)
        parts.append(f'<div class="ends">{"".join(f"<span>{end}</span>" for end in ends)}</div>')
    return "".join(parts) + "".join(paragraph(note, "note") for note in legend.notes)
