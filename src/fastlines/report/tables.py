"""The figures of trees side by side: tables of a page, lines of a terminal, and an answer in words."""

from __future__ import annotations

import statistics
from collections.abc import Sequence

from ..support.texts import counted
from .measure import LEAST, QUERIES, TreeFigures
from .page import cell, table

#: The answer also names trees that take at most this many times as long as the fastest.
NEAR = 1.1


def format_3_digits(value: float) -> str:
    """Write a figure with about three digits.

    Examples
    --------
    >>> [format_3_digits(value) for value in (1234.5, 99.96, 12.345, 0.12345, 0.012345)]
    ['1,234', '100', '12.3', '0.12', '0.012']
    """
    digits = 0 if value >= 99.95 else 1 if value >= 9.995 else 2 if value >= 0.0995 else 3
    return f"{value:,.{digits}f}"


def trees_table(rows: Sequence[TreeFigures]) -> str:
    """Return the table of the sizes, costs and builds of trees."""
    heads = ["tree", "references", "nodes", "depth", "cost", "memory, MB", "build, s"]
    body = []
    for row in rows:
        if row.over_s is not None:
            body.append([cell(row.method, tag="th"), *[cell("–")] * 5, cell(f"over {row.over_s:g}")])
            continue
        counts = [cell(f"{n:,}", n) for n in (row.n_refs, row.n_nodes, row.depth)]
        figures = [cell(format_3_digits(value), value) for value in (row.cost, row.bytes / 1e6, row.build_s)]
        body.append([cell(row.method, tag="th"), *counts, *figures])
    note = (
        "The cost is that of a random line through the scene (thesis §3.3), with c_prim = 1 and c_trav = 2 for BVHs, "
        "0.6 for KD trees. It counts one test at a time. Queries test up to 16 segments at once, in the leaves of the "
        "layout, and best is built for that: it has few, large leaves. So its cost is often the highest, though its "
        "queries are fast. The memory is that of the layout and the segments."
    )
    return table(heads, body, "The trees", note)


def queries_table(rows: Sequence[TreeFigures]) -> str:
    """Return the table of millions of rays a second, with bars."""
    rates = {row.method: [*row.mrays.values(), *row.as_built.values()] for row in rows if row.over_s is None}
    most = [max(column) for column in zip(*rates.values(), strict=True)]
    body = [
        [cell(method, tag="th"), *(cell(format_3_digits(n), n, n / top) for n, top in zip(row, most, strict=True))]
        for method, row in rates.items()
    ]
    heads = ["tree", *(f"{query.capitalize()} {letter}" for query, letter in QUERIES)]
    note = (
        "First finds the nearest hit of each ray, All lists all hits. The camera's rays are traced on all threads. "
        "As built searches the binary tree, one ray at a time, and shows how the trees differ. " + noise_text(rows)
    )
    caption = "Queries: millions of rays a second; a longer bar is faster"
    return table([*heads, "First M, as built", "All M, as built"], body, caption, note)


def noise_text(rows: Sequence[TreeFigures]) -> str:
    """Say how noisy the times are.

    Examples
    --------
    >>> noise_text([TreeFigures("best", noise=[0.02, 0.08, 0.05])])
    'The best of at least 3 rounds counts. The median round took 5 % longer: smaller differences are noise.'
    """
    noise = [each for row in rows for each in row.noise]
    typical = f" The median round took {100 * statistics.median(noise):.2g} % longer" if noise else ""
    return f"The best of at least {LEAST} rounds counts.{typical}{': smaller differences are noise.' if noise else ''}"


def print_trees(title: str, n_segments: int, rows: Sequence[TreeFigures]) -> None:
    """Print a line for each tree."""
    print(f"{title}: {counted(n_segments, 'segments')}")
    print(f"{'tree':8}{'build s':>9}{'cost':>10}{'MB':>8}{'first M':>11}{'all M':>11}   Mrays/s")
    for row in rows:
        if row.over_s is not None:
            print(f"{row.method:8}  the build did not end within {row.over_s:g} s")
            continue
        figures = row.build_s, row.cost, row.bytes / 1e6, row.mrays["first M"], row.mrays["all M"]
        print("{:8}{:>9}{:>10}{:>8}{:>11}{:>11}".format(row.method, *map(format_3_digits, figures)))
    print(flush=True)


def answer_points(rows: Sequence[TreeFigures]) -> list[tuple[str, str]]:
    """Return which tree is fastest for each query, which is built first, and which builds exceeded the limit."""
    known = {row.method: row for row in rows if row.over_s is None}
    points = []
    for column, what in (("first M", "First hits"), ("all M", "All hits")) if known else ():
        rates = {name: row.mrays[column] for name, row in known.items()}
        fastest = max(rates, key=lambda name: rates[name])
        near = [name for name in rates if name != fastest and rates[fastest] <= NEAR * rates[name]]
        said = f"{fastest} is fastest, {format_3_digits(rates[fastest])} million rays a second"
        said += f"; within a tenth of it: {', '.join(near)}" if near else ""
        if "best" in rates and "best" not in (fastest, *near):
            said += f"; best takes {rates[fastest] / rates['best']:.1f} times as long"
        points.append((what, said + "."))
    if known:
        quickest = min(known.values(), key=lambda row: row.build_s)
        said = f"{quickest.method} is built first, in {format_3_digits(quickest.build_s)} s"
        if "best" in known and quickest.method != "best":
            said += f"; best, which fl.build(lines) makes, in {format_3_digits(known['best'].build_s)} s"
        points.append(("Builds", said + "."))
    over = [f"the build of {row.method} did not end within {row.over_s:g} s" for row in rows if row.over_s is not None]
    if over:
        points.append(("Left out", "; ".join(over) + "."))
    points.append(("Measured with", "the rays of a camera that looks at all of the lines, with the radius M."))
    return points
