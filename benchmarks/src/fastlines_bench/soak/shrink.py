"""Makes a case that fails as small as it gets: a few primitives, one ray, defaults, and short numbers."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from .case import Case, Question
from .parts import Part
from .scenes import Array

#: Whether a case still fails.
Fails: TypeAlias = Callable[[Case], bool]

#: Arguments that a query needs.
NEEDED = {"origins", "directions", "points", "low", "high", "k", "max_bytes", "blur"}


def shrink(case: Case, fails: Fails, seconds: float = 30.0) -> Case:
    """Return a smaller case that fails too; the search ends after so many seconds of processor time.

    It is delta debugging (Zeller and Hildebrandt 2002): rows are left out in halves, quarters, … as long as the case
    fails, and then options, settings and digits one by one, until nothing more can be left out. Primitives come before
    settings: a default build would need more of them.
    """
    end = time.process_time() + seconds

    def still_fails(smaller: Case) -> bool:
        return time.process_time() < end and fails(smaller)

    before = None
    while before is not case and time.process_time() < end:
        before = case
        for smaller in (_fewer_prims, _fewer_rows, _without_options, _without_settings, _shorter_numbers):
            case = smaller(case, still_fails)
    return case


def _first(case: Case, candidates: Iterator[Case], fails: Fails) -> Case:
    """Return the first candidate that fails, or else the case."""
    return next((smaller for smaller in candidates if fails(smaller)), case)


def _each(case: Case, candidates: Callable[[Case], Iterator[Case]], fails: Fails) -> Case:
    """Replace the case by a candidate that fails, made from it, as long as there is one."""
    while (smaller := _first(case, candidates(case), fails)) is not case:
        case = smaller
    return case


def _without_settings(case: Case, fails: Fails) -> Case:
    def candidates(case: Case) -> Iterator[Case]:
        if case.build:
            yield replace(case, build={})
        for name in case.build:
            yield replace(case, build=_without(case.build, name))
        for i in range(len(case.steps)):
            yield replace(case, steps=case.steps[:i] + case.steps[i + 1 :])
        if case.offset is not None:
            yield replace(case, offset=None)
        if case.spoiled:
            yield replace(case, spoiled=case.spoiled[1:])
        if case.frame is not None:
            yield replace(case, frame=None)
        for i in range(len(case.parts)):
            if len(case.parts) > 1:
                yield replace(case, parts=case.parts[:i] + case.parts[i + 1 :])
        for question in case.questions:
            for changed in (
                replace(question, other=None),
                replace(question, kernel="auto"),
                replace(question, simd=None),
                replace(question, n_threads=1),
            ):
                if changed != question:
                    yield case.alone(changed)

    return _each(case, candidates, fails)


def _without(given: dict[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in given.items() if key != name}


def minimised(n: int, fails: Callable[[Array], bool]) -> Array:
    """Return a small set of the first n numbers that fails, if all of them do."""
    kept, size = np.arange(n), n
    while size > 1 or (size == 1 and n > 0):
        size = max(1, size // 2)
        begin = 0
        while begin < len(kept):
            rest = np.concatenate([kept[:begin], kept[begin + size :]])
            if fails(rest):
                kept = rest
            else:
                begin += size
        if size == 1:
            return kept
    return kept


def _fewer_prims(case: Case, fails: Fails) -> Case:
    kept = minimised(case.n_prims, lambda rows: fails(case.some(rows)))
    return case if len(kept) == case.n_prims else case.some(kept)


def _fewer_rows(case: Case, fails: Fails) -> Case:
    for question in case.questions:
        kept = minimised(len(question), partial(_fails_with, case, question, fails))
        if len(kept) < len(question):
            return case.alone(question.some(kept))
        if (other := question.other) is not None:
            kept = minimised(len(other), partial(_fails_beside, case, question, other, fails))
            if len(kept) < len(other):
                return case.alone(replace(question, other=other.some(kept)))
    return case


def _fails_beside(case: Case, question: Question, other: Part, fails: Fails, rows: Array) -> bool:
    return fails(case.alone(replace(question, other=other.some(rows))))


def _fails_with(case: Case, question: Question, fails: Fails, rows: Array) -> bool:
    return len(rows) > 0 and fails(case.alone(question.some(rows)))


def _without_options(case: Case, fails: Fails) -> Case:
    def candidates(case: Case) -> Iterator[Case]:
        for question in case.questions:
            for name in question.rows.keys() - NEEDED:
                yield case.alone(replace(question, rows=_without(question.rows, name)))
            for name in question.options.keys() - NEEDED:
                yield case.alone(replace(question, options=_without(question.options, name)))
            if question.options.get("k", 1) > 1:
                yield case.alone(replace(question, options={**question.options, "k": question.options["k"] // 2}))
        for i, part in enumerate(case.parts):
            for name in part.rows.keys() & {"radius", "strands"} if part.kind in ("lines", "cones") else ():
                plain = replace(part, rows=_without(part.rows, name))
                yield replace(case, parts=(*case.parts[:i], plain, *case.parts[i + 1 :]))

    return _each(case, candidates, fails)


def _shorter_numbers(case: Case, fails: Fails) -> Case:
    """Round the arrays of the case to few digits, each as a whole and then each number."""
    for place, values in list(_arrays(case)):
        if values.dtype.kind != "f":
            continue
        for digits in (1, 2, 3, 4):
            rounded = rounded_to(values, digits)
            if (rounded != values).any() and fails(_with_array(case, place, rounded)):
                case, values = _with_array(case, place, rounded), rounded
                break
        if values.size > 64:
            continue
        for at in range(values.size):
            for number in (0.0, 1.0, *(rounded_to(values.flat[at : at + 1], digits)[0] for digits in (1, 2, 3, 4))):
                if values.flat[at] == number:
                    break
                changed = values.copy()
                changed.flat[at] = number
                if fails(_with_array(case, place, changed)):
                    case, values = _with_array(case, place, changed), changed
                    break
    return case


#: Where an array is: in a part or in the question, and its name.
Place: TypeAlias = tuple[int | None, str]


def _arrays(case: Case) -> Iterator[tuple[Place, Array]]:
    for i, part in enumerate(case.parts):
        for name, values in part.rows.items():
            yield (i, name), values
    for question in case.questions:
        for name, values in question.rows.items():
            yield (None, name), values


def _with_array(case: Case, place: Place, values: Array) -> Case:
    number, name = place
    if number is None:
        question = case.questions[0]
        return case.alone(replace(question, rows={**question.rows, name: values}))
    part: Any = case.parts[number]
    changed = replace(part, rows={**part.rows, name: values})
    return replace(case, parts=(*case.parts[:number], changed, *case.parts[number + 1 :]))


def rounded_to(values: Array, digits: int) -> Array:
    """Return numbers rounded to so many significant digits, in their type.

    Examples
    --------
    >>> rounded_to(np.array([1234.5, 0.0456, 0, np.inf]), 2).tolist()
    [1200.0, 0.046, 0.0, inf]
    """
    texts = [f"{x:.{digits - 1}e}" for x in np.asarray(values, np.float64).reshape(-1)]
    return np.array(texts, np.float64).astype(values.dtype).reshape(values.shape)
