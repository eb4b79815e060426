"""The text of a C++ source as the search for mutants needs it: without comments, and with brackets in pairs."""

from __future__ import annotations

import re

_SKIPPED = re.compile(
    r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#[^\n]*(?:\\\n[^\n]*)*', re.S | re.M
)
_DIGITS = re.compile(r"(?<=[0-9a-f])'(?=[0-9a-f])")
PAIRS = {"(": ")", "[": "]", "{": "}"}


def without_comments(text: str) -> str:
    """Return a text of the same length in which comments are spaces."""
    return _SKIPPED.sub(lambda m: _blank(m[0]) if m[0].startswith(("//", "/*")) else m[0], text)


def only_code(text: str) -> str:
    """Return a text of the same length in which comments, strings, and lines of the preprocessor are spaces."""
    return _SKIPPED.sub(lambda m: _blank(m[0]), _DIGITS.sub("_", text))


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)


def closing(code: str, at: int) -> int:
    """Return where the bracket that opens at a place is closed; the end of the code if it is not."""
    depth = 0
    for i in range(at, len(code)):
        depth += (code[i] in "([{") - (code[i] in ")]}")
        if depth == 0:
            return i
    return len(code)


def end_of_operand(code: str, at: int) -> int:
    """Return the end of an operand of && or || that begins at a place."""
    i = at
    while i < len(code):
        if code[i] in "([{":
            i = closing(code, i)
        elif code[i] in ")]},;?" or code.startswith(("&& ", "|| ", "&&\n", "||\n", " : "), i):
            break
        i += 1
    return at + len(code[at:i].rstrip())


def arguments(code: str, begin: int, end: int) -> list[tuple[int, int]]:
    """Return the ranges of the arguments between two brackets."""
    found, start, i = [], begin, begin
    while i < end:
        if code[i] in "([{":
            i = closing(code, i)
        elif code[i] == ",":
            found.append((start, i))
            start = i + 1
        i += 1
    return [*found, (start, end)]


def one_line(text: str) -> str:
    """Return a text with single spaces."""
    return " ".join(text.split())


def around(code: str, start: int, end: int) -> tuple[str, str]:
    """Return the words before and after a range, which tell it from others of its line."""
    before = re.search(r"[\w.\])(\[]*\s*[-+*/=<>&|,?:({]*\s*$", code[max(start - 24, 0) : start])
    after = re.match(r"\s*[\w.(\[:-]*", code[end : end + 24])
    return one_line(before[0] if before else ""), one_line(after[0] if after else "")
