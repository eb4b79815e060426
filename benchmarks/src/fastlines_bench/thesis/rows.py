"""The rows of a table: seven configurations of the thesis, and rows that it does not have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fastlines.scenes import RADII

from ..harness.internals import DEFAULT_METHOD, THESIS_METHODS
from .reference import Reference
from .store import Found

#: The queries, in the order of the thesis's tables.
KINDS = ("first", "all")
QUERIES = tuple((kind, letter) for kind in KINDS for letter in RADII)
#: The columns of times, as in the thesis.
TIMES = tuple(f"{query} {letter}" for query, letter in QUERIES)
#: The titles of the rows in the thesis, in its order.
TITLES = {
    **{method: method.upper().replace("-", "::") for method in THESIS_METHODS},
    "embree": "Embree",
    "embree-ps": "Embree PS",
}
#: The rows of Embree.
PEERS = ("embree", "embree-ps")
#: The titles of rows that the thesis does not have.
MORE_TITLES = {
    DEFAULT_METHOD: "best, fast engine",
    "embree-filter": "Embree, by filter",
    "embree-ps-filter": "Embree PS, by filter",
}


@dataclass(frozen=True)
class Row:
    """One configuration over one subject; None = not measured.

    Attributes
    ----------
    name : str
        A method, "embree", "embree-ps", or one of these with "-filter".
    ms : dict of str to float
        Milliseconds, by the columns `TIMES`; inf = did not finish.
    parts : dict of str to int
        The number of rays on which a time was measured, if not on all.
    over_s : float or None
        The limit in seconds that the build exceeded, if it did.
    """

    name: str
    ms: Mapping[str, float]
    n_prims: int | None = None
    build_ms: float | None = None
    n_nodes: int | None = None
    cost: float | None = None
    parts: Mapping[str, int] | None = None
    over_s: float | None = None

    @property
    def title(self) -> str:
        """The title of the row in the tables."""
        return {**TITLES, **MORE_TITLES}[self.name]

    def figure(self, column: str) -> float | None:
        """Return the value of a column: a time or an attribute."""
        return self.ms.get(column) if column in TIMES else getattr(self, column)


def row_of(name: str, found: Found) -> Row:
    """Return the row of a step's result."""
    if "over_s" in found:
        return Row(name, {}, over_s=found["over_s"])
    filtered = name.endswith("-filter")
    keys = {time: time.replace("all", "filter") if filtered else time for time in TIMES}
    times = {time: found["times"][key] for time, key in keys.items() if not filtered or time.startswith("all")}
    return Row(
        name,
        {time: timed["ms"] for time, timed in times.items()},
        found["n_prims"],
        1e3 * found["build_s"],
        found.get("n_nodes"),
        found.get("cost"),
        {time: timed["n_measured"] for time, timed in times.items() if timed["n_measured"] < timed["n_rays"]},
    )


def thesis_row(name: str, reference: Reference) -> Row:
    """Return the row of the thesis's figures."""
    times: dict[str, Any] = {}
    for query, figures in (("first", reference.first_ms), ("all", reference.all_ms)):
        for letter, ms in zip("WMN", figures or (float("inf"),) * 3, strict=True):
            times[f"{query} {letter}"] = float(ms)
    return Row(name, times, reference.n_prims, reference.build_ms, reference.n_nodes, reference.cost)
