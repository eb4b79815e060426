"""Which tree suits somebody's lines, told from what was measured."""

from __future__ import annotations

from collections.abc import Mapping

from ..bench.table import three
from ..methods import DEFAULT_METHOD, THESIS_METHODS
from .document import Section
from .rows import Row

#: The search takes so much longer than the least time before a cheaper build is no reason any more.
NEAR = 1.1


def answer_section(rows: Mapping[str, Row]) -> Section:
    """Name the fastest row of each kind of question, and what building it takes."""
    points = []
    for column, what in (("first M", "First hits"), ("all M", "All hits")):
        asked = {row.name: row.ms[column] for row in rows.values() if column in row.ms}
        if not asked:
            continue
        best = rows[min(asked, key=lambda name: asked[name])]
        near = [name for name in asked if name != best.name and asked[name] <= NEAR * asked[best.name]]
        said = f"{best.title} is fastest, {three(asked[best.name])} ms"
        said += f"; within a tenth of it: {', '.join(rows[name].title for name in near)}" if near else ""
        if DEFAULT_METHOD in asked and DEFAULT_METHOD not in (best.name, *near):
            longer = asked[DEFAULT_METHOD] / asked[best.name]
            said += f"; {rows[DEFAULT_METHOD].title} takes {longer:.1f} times as long"
        points.append((what, said + "."))
    trees = [rows[name] for name in THESIS_METHODS if name in rows and "first M" in rows[name].ms]
    if trees:
        first = min(trees, key=lambda row: row.ms["first M"])
        cheap = min(trees, key=lambda row: row.build_ms or 0.0)
        said = f"{first.title} answers first hits fastest ({three(first.ms['first M'])} ms, built in {_s(first)} s)"
        if cheap is not first:
            longer = cheap.ms["first M"] / first.ms["first M"]
            said += f"; {cheap.title} is built fastest ({_s(cheap)} s) and takes {longer:.1f} times as long"
        points.append(("Of the thesis’s trees", said + "."))
    best_row = rows.get(DEFAULT_METHOD)
    if best_row is not None and best_row.build_ms is not None:
        points.append(
            ("The default", f"fl.build(lines) makes {DEFAULT_METHOD}: built in {_s(best_row)} s with one thread.")
        )
    over = [
        f"{row.title}: the build did not end within {row.over_s:g} s" for row in rows.values() if row.over_s is not None
    ]
    if over:
        points.append(("Left out", "; ".join(over) + "."))
    text = (
        "Measured at the radius M, with the rays of a camera that looks at all of the lines; other rays may like "
        "another tree."
    )
    return Section("answer", "Which tree suits these lines", [text], points=points)


def _s(row: Row) -> str:
    return three((row.build_ms or 0.0) / 1e3)
