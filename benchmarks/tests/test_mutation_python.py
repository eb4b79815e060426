"""Mutants of Python: the choices in a small module, and real modules that a process imports with their mutants."""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from typing import Any

import pytest

from fastlines_bench.mutation.mutant import Mutant
from fastlines_bench.mutation.python_run import Worker
from fastlines_bench.mutation.python_schemata import SWITCH, numeric_limits, schemata
from fastlines_bench.mutation.python_sources import MutatedSources, package_folder
from fastlines_bench.mutation.trial import try_mutants

pytestmark = [
    pytest.mark.usefixtures("in_own_folder"),
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the switches are shared memory, on Linux"),
]

SOURCE = """
MOST = 1 << 4
NAME = "a"

def share(values: list[int], first: int = 2) -> float:
    if not values or len(values) > MOST:
        advice = "at most " + NAME
        raise ValueError(f"{len(values) + 1} values; {advice}")
    total = 0
    for value in values[first - 2 : len(values)]:
        total += value
    return max(total, 4) / 2

def text(n: int) -> str:
    return "one" if n == 1 else "several"
"""

#: Arguments that tell each mutant of `share` from the original.
ARGUMENTS: list[tuple[list[int], int]] = [
    ([], 2), ([1, 2, 3, 4], 2), ([1, 2, 3, 4], 4), ([0], 2), ([1] * 15, 2), ([1] * 16, 2), ([1] * 17, 2), ([1] * 33, 2),
    ([9, 9], 2),
]  # fmt: skip

TESTS = """
import pytest
from fastlines import InputError
from fastlines.arrays import count

def test_a_count():
    assert count("n", 3, 1, 5) == 3
    with pytest.raises(InputError):
        count("n", 6, 1, 5)
"""


class OneOn:
    """A switch on which one mutant is on."""

    def __init__(self, number: int) -> None:
        self.number = number

    def at(self, first: int, last: int) -> bool:
        return first <= self.number <= last

    def is_on(self, number: int) -> bool:
        return self.number == number


def mutated(source: str, **options: Any) -> tuple[ast.Module, list[Mutant]]:
    tree = ast.parse(source)
    return tree, schemata(tree, "a.py", 1, numeric_limits(tree), **{"refusals_only": False, **options})


def answers(tree: ast.Module, number: int) -> list[object]:
    module: dict[str, Any] = {SWITCH: OneOn(number)}
    exec(compile(tree, "a.py", "exec"), module)
    found: list[object] = []
    for arguments in ARGUMENTS:
        try:
            found.append(module["share"](*arguments))
        except Exception as error:
            found.append(type(error))
    return found


def test_mutants_of_a_module():
    changes = {(mutant.original, mutant.replacement) for mutant in mutated(SOURCE)[1]}
    assert ("len(values) > MOST", "len(values) >= MOST") in changes
    assert ("not values or len(values) > MOST", "False") in changes
    assert ("MOST", "MOST * 2") in changes
    assert ("total += value", "total -= value") in changes
    assert ("len(values)", "len(values) - 1") in changes
    assert ("max(total, 4)", "min(total, 4)") in changes
    # Neither the text of an error nor what runs once, at the import.
    left_alone = ("advice", "at most", "1 <<", "n == 1")
    assert not [change for change in changes if any(text in change[0] for text in left_alone)]


def test_limits_are_numbers_with_a_name_in_capitals():
    source = "A, B = 1 << 4, 0.5\nC = (1, 2)\nD = -1\nE = 'e'\nF = True\nother = 3\nG = [1]\nH = A"
    assert numeric_limits(ast.parse(source)) == {"A": int, "B": float, "D": int}


def test_each_mutant_is_a_choice_on_its_switch():
    tree, mutants = mutated(SOURCE)
    usual = [ValueError, 5.0, 3.5, 2.0, 7.5, 8.0, ValueError, ValueError, 9.0]
    assert answers(tree, 0) == usual
    assert [mutant.number for mutant in mutants] == list(range(1, len(mutants) + 1))
    for mutant in mutants:
        assert answers(tree, mutant.number) != usual, mutant


def test_only_what_refuses_something_may_be_mutated():
    source = "def half(n):\n    return n // 2\n\ndef check(n):\n    if n < 1:\n        raise ValueError(n)\n"
    assert {mutant.place for mutant in mutated(source)[1]} == {"half", "check"}
    assert {mutant.place for mutant in mutated(source, refusals_only=True)[1]} == {"check"}


def test_mutants_of_the_package():
    Path("test_some.py").write_text(TESTS)
    of_count = [mutant for mutant in MutatedSources(package_folder()).mutants if mutant.place.startswith("count: ")]
    changes = ("isinstance(given, bool) or", "most is None", "least <= given <= end")
    some = [mutant for mutant in of_count if mutant.file == "arrays.py" and mutant.original.startswith(changes)]
    assert some
    elsewhere = Mutant(60000, "arrays.py", 1, "number", "", "")
    told: list[str] = []
    numbers = [mutant.number for mutant in (*some, elsewhere)]
    worker = Worker(Path.cwd(), ["test_some.py"], Path("switches").resolve(), numbers)
    try_mutants([worker], [*some, elsewhere], 9.0, lambda *_: None, told.append)
    status = {(mutant.original, mutant.replacement): mutant.status for mutant in some}
    assert elsewhere.status == "not reached"
    assert set(status.values()) == {"killed", "survived"}
    assert status["most is None", "most is not None"] == "killed"  # 6 is no longer too many
    assert len(told) == 1 + list(status.values()).count("survived")
