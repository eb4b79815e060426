"""Mutants that were looked at and give the same answers, with the reason; the list is equal.csv."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path

from .mutant import Mutant

FILE = Path(__file__).with_name("equal.csv")


def reasons(path: Path = FILE) -> dict[tuple[str | int, ...], str]:
    """Return why mutants are equal, by their keys."""
    with path.open(newline="", encoding="utf-8") as file:
        return {
            (row["file"], row["place"], row["original"], row["replacement"], int(row["nth"])): row["reason"]
            for row in csv.DictReader(file)
        }


def mark_equal(mutants: Iterable[Mutant]) -> None:
    """Give the mutants of the list that no test noticed the status "equal"."""
    known = reasons()
    for mutant in mutants:
        if mutant.is_undetected and mutant.key in known:
            mutant.status, mutant.by = "equal", known[mutant.key]
