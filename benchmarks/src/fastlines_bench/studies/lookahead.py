"""The table of the thesis's §4.3 with more figures: the gain and the cost of lookahead.

The thesis has costs of 100, 13.0, 12.7 and 12.5. Ours decrease in the same way, but from 24.5 on. With a c_trav of
0.6, which reproduces the costs of the thesis's KD trees in §6, they decrease from 15.7 on: most of the gap is the
constant. A deeper search need not build a better tree, because each node starts a new search: with one of eight seeds,
depth 3 costs more than depth 2.
"""

from __future__ import annotations

from typing import Any

from ..thesis.depths import THESIS_DEPTHS, time_depth


def print_lookahead(seed: int, c_trav: float) -> list[dict[str, Any]]:
    """Print the table as Markdown, and return its rows."""
    rows = [time_depth(depth, seed, c_trav) for depth in THESIS_DEPTHS]
    print("| depth | cost | nodes | exhaustive | carried out | branch and bound | carried out | octets |")
    print("|---|---|---|---|---|---|---|---|")
    for row in rows:
        print(
            f"| {row['depth']} | {row['cost']:.1f} | {row['n_nodes']} "
            f"| {row['exhaustive_ms']:.2f} ms | {row['exhaustive_carried_out']:,} "
            f"| {row['build_ms']:.2f} ms | {row['carried_out']:,} | {row['octets_ms']:.2f} ms |"
        )
    return rows
