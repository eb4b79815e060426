"""The tables of all builders: what their trees cost, and what ought to hold."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from ..demo.tables import print_table, wide_console
from .builders import THESIS_COST
from .claims import Claim
from .pareto import Pareto, Row, front
from .rays import QUESTIONS
from .table import three


def print_pareto(pareto: Pareto) -> None:
    """Print a table for each scene, a row for each builder, then the list of claims."""
    console = wide_console()
    scenes = pareto.scenes()
    for scene in dict.fromkeys([*scenes, *(over.scene for over in pareto.over)]):
        print_table(console, _measured(pareto, scene, scenes.get(scene, [])))
    if pareto.rows:
        print_table(console, _claims(pareto.claims()))
    plan = pareto.plan
    costs = ", ".join(f"{cost.c_trav:g} ({kind})" for kind, cost in THESIS_COST.items())
    threads = f"{plan.n_threads} thread{'s' if plan.n_threads > 1 else ''}"
    peer = f"Embree {pareto.machine['embree']}: the build that is asked fastest. " if plan.peer else ""
    console.print(
        f"{threads}. cost: with the builder's own c_trav; alike: with c_trav {costs} for all. build: the median "
        f"of up to {plan.rounds}. Queries: ns a ray, the best of {plan.rounds}; mean: geometric, of the four. * on the "
        "front of build and mean query time. over: did not end within "
        f"{plan.limit:g} s, so nothing else is known. {peer}All answers are the same, bit for bit. "
        f"{pareto.seconds:.0f} s in all.",
        highlight=False,
    )


def _measured(pareto: Pareto, scene: str, rows: Sequence[Row]) -> Table:
    segments = f": {rows[0].n_segments:,} segments" if rows else ""
    table = Table(title=f"{scene}{segments}", title_justify="left", pad_edge=False)
    table.add_column("builder", style="bold", no_wrap=True)
    heads = ["references", "nodes", "cost", "alike", "build\ns", "layout\ns"]
    heads += ["\n".join(question) for question in QUESTIONS] + ["mean"]
    for head in heads:
        table.add_column(head, justify="right", no_wrap=True)
    ahead = front([(row.build_s, row.query_ns) for row in rows])
    for i, row in enumerate(rows):
        table.add_row(row.builder, *_cells(row, i in ahead))
    for over in pareto.over:
        if over.scene == scene:
            table.add_row(over.builder, f"over {over.seconds:g} s")
    for peer in pareto.peers:
        if peer.scene == scene:
            table.add_row("Embree", "", "", "", "", three(peer.build_s))
    return table


def _cells(row: Row, ahead: bool) -> list[str]:
    return [
        f"{row.n_refs:,}",
        f"{row.n_nodes:,}",
        _cost(row.cost),
        _cost(row.thesis_cost),
        three(row.build_s),
        three(row.layout_s),
        *(f"{ns:,.0f}" for ns in row.ns.values()),
        f"{row.query_ns:,.0f}{'*' if ahead else ' '}",
    ]


def _cost(cost: float) -> str:
    return f"{cost:,.1f}" if cost >= 99.5 else f"{cost:.2f}"


def _claims(claims: Sequence[Claim]) -> Table:
    table = Table(title="what ought to hold", title_justify="left", pad_edge=False)
    table.add_column("scene", style="bold", no_wrap=True)
    table.add_column("")
    for head in ("measured", "at most"):
        table.add_column(head, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for claim in claims:
        figures = ["–" if value is None else f"{value:,.4g}" for value in (claim.value, claim.bound)]
        said = {True: "holds", False: "[red]does not hold[/]", None: "not measured"}[claim.holds]
        table.add_row(claim.scene, claim.says, *figures, said)
    return table
