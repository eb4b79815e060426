"""A query about points, from the arguments of a command to its table and figures."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import typer

from ..support.texts import counted
from .answer_columns import check_samples, columns_of_points
from .array_files import numbers
from .files import open_input, show_progress, tree_of
from .point_files import point_of, read_points
from .tables import check_table, header, rows_of_text, table_writer


@dataclass(frozen=True)
class PointQuery:
    """Arguments that the commands about points share; their help explains them."""

    source: str
    points: str
    to: str | None
    output: str | None
    samples: Sequence[str] | None
    ignore: str | None
    ignore_strands: str | None
    parts: str | None
    as_json: bool

    def run(self, method: str, settings: Mapping[str, Any], opening: tuple[Any, ...]) -> None:
        """Ask a tree by one of its methods, write the table, and print figures.

        Parameters
        ----------
        method : {"nearest", "within"}
        settings : mapping
            The arguments of that method alone.
        opening : tuple
            How the input is read: the further arguments of `open_input`.
        """
        check_table(self.output, (self.source, self.points))
        options = {
            "to": self.to,
            "ignore": numbers(self.ignore, "--ignore"),
            "ignore_strands": numbers(self.ignore_strands, "--ignore-strands"),
            "parts": numbers(self.parts, "--parts"),
            "progress": show_progress(),
        }
        points = read_points(self.points)
        opened = open_input(self.source, *opening, forests=True)
        samples = list(self.samples or ())
        check_samples(opened.geometry, samples)
        tree = tree_of(opened)
        start = time.perf_counter()
        answer = getattr(tree, method)(points, **settings, **options)
        seconds = time.perf_counter() - start

        # Show what is found for a point on the command line.
        is_typed = point_of(self.points) is not None
        shown = is_typed and self.output is None
        columns = columns_of_points(answer, _point_of_rows(answer), samples) if self.output or shown else {}
        if self.output is not None:
            with table_writer(self.output) as append:
                append(columns)
        n_points, n_found = len(points), int((answer.prim >= 0).sum())
        if self.as_json:
            facts = {"n_points": n_points, **settings, "n_found": n_found, "seconds": seconds, "output": self.output}
            table = {"answer": {name: values.tolist() for name, values in columns.items()}} if shown else {}
            typer.echo(json.dumps(facts | table, indent=2))
            return
        rate = f", {n_points / seconds / 1e6:.3g} million points a second" if n_points and not is_typed else ""
        what = f"{counted(n_points, 'points')}, {counted(n_found, 'primitives')} found"
        typer.echo(f"{self.output or opened.name}: {what}, in {seconds:.3f} s{rate}")
        if shown:
            typer.echo(header(columns) + "".join(rows_of_text(columns)), nl=False)


def _point_of_rows(answer: Any) -> npt.NDArray[np.int64]:
    """Return the number of the point of each row of an answer."""
    if hasattr(answer, "offsets"):
        return np.asarray(answer.point)
    n_points = len(answer.prim)
    return np.repeat(np.arange(n_points), answer.prim.size // max(n_points, 1))
