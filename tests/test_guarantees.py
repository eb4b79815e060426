"""Each promise of docs/guarantees.md names tests, and these tests exist."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "guarantees.md").read_text(encoding="utf-8")
#: A link to a test: its path, its name, where the link leads, and whether it is said to be slow.
TEST = re.compile(r"\[`([\w/.]+)::(\w+)`\]\(([^)]+)\)( \*weekly\*)?")
#: The promises by their first words: lines of a list that begin with something bold.
PROMISES = {
    entry.split("**")[1].rstrip("."): entry for entry in re.findall(r"^- \*\*.*\n(?:  .*\n)*", PAGE, re.MULTILINE)
}


@cache
def functions(path: str) -> dict[str, list[str]]:
    """Return the functions of a file at its top level, and their decorators."""
    text = (ROOT / path).read_text(encoding="utf-8")
    if path.endswith(".cpp"):
        return {name: [] for name in re.findall(r"^\w[^;()\n]*?\b(\w+)\([^;]*?\) \{", text, re.MULTILINE)}
    found = [node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)]
    return {function.name: [ast.unparse(decorator) for decorator in function.decorator_list] for function in found}


@pytest.mark.parametrize("promise", PROMISES)
def test_a_promise_names_tests_that_exist(promise: str) -> None:
    tests = TEST.findall(PROMISES[promise])
    assert tests
    for path, name, link, is_weekly in tests:
        assert link == f"../{path}"
        assert name in functions(path), f"{path}::{name}"
        is_slow = any(how == "pytest.mark.slow" or "n=0)" in how for how in functions(path)[name])
        assert bool(is_weekly) == is_slow, f"{path}::{name}"


def test_all_tests_of_the_page_are_those_of_promises() -> None:
    assert len(PROMISES) > 50
    assert len(TEST.findall(PAGE)) == sum(len(TEST.findall(entry)) for entry in PROMISES.values())


def test_each_row_of_the_table_has_its_tests() -> None:
    rows = re.findall(r"^\| \*\*(.+?)\*\*", PAGE, re.MULTILINE)
    assert len(rows) == 10
    assert set(rows) <= PROMISES.keys()


def test_tests_are_found_by_their_names() -> None:
    assert "test_tests_are_found_by_their_names" in functions("tests/test_guarantees.py")
    assert {"check_case", "check_spread", "main"} <= functions("cpp/tests/round_cones.cpp").keys()
    assert "check_cases" not in functions("cpp/tests/round_cones.cpp")
