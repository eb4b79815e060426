"""Compares the answers of a case: whether any of them differs from that of brute force."""

from __future__ import annotations

import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path

from .answers import REFUSALS, by_brute_force, error_columns, first_difference, found_by_tree
from .case import Case
from .trees import Subject, subject_of

#: What tells an error from another answer in a description.
RAISES = " raises "


@dataclass(frozen=True)
class Outcome:
    """What became of a question: the difference if there is one, and whether both sides have refused it."""

    difference: str | None = None
    is_refused: bool = False


def outcomes(case: Case) -> list[Outcome]:
    """Build the tree of a case, and return the outcome of each question; none if the build is refused."""
    with tempfile.TemporaryDirectory(prefix="fastlines-soak-") as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            subject = subject_of(case, Path(folder))
        except REFUSALS:
            return []
        except Exception as error:
            return [Outcome(f"the build raises {error_columns(error)['error']}")]
        return [_outcome(subject, case, i) for i in range(len(case.questions))]


def _outcome(subject: Subject, case: Case, number: int) -> Outcome:
    question = case.questions[number]
    found, expected = found_by_tree(subject, case, question), by_brute_force(subject, case, question)
    return Outcome(first_difference(found, expected), "error" in expected)


def difference(case: Case) -> str | None:
    """Return the first difference of a case; None if there is none."""
    return next((one.difference for one in outcomes(case) if one.difference is not None), None)


def is_same_kind(why: str | None, other: str) -> bool:
    """Return whether two differences are of one kind: the same error of the same side, or different answers."""
    if why is None or RAISES not in other:
        return why is not None and RAISES not in why
    return why.partition("(")[0] == other.partition("(")[0]
