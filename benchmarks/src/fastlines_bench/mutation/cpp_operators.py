"""Which places of a C++ source can be mutated, and what is written there instead.

A place is found by its text. The sources are formatted by clang-format, which puts spaces around binary operators and
none inside angle brackets and pointers. What does not compile after all is left out later, by what the compiler says.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from .cpp_text import arguments, closing, end_of_operand

#: Returns the mutated text of a range, in one line.
Inner = Callable[[int, int], str]


@dataclass(frozen=True)
class Place:
    """A range of the code, what may replace it, and how to write the choice among the numbers of its mutants."""

    start: int
    end: int
    choices: tuple[tuple[str, str], ...]
    write: Callable[[Sequence[int], Inner], str]


_OPERATORS = {
    "<": ("Less", "<=", ">="),
    "<=": ("LessEqual", "<", ">"),
    ">": ("Greater", ">=", "<="),
    ">=": ("GreaterEqual", ">", "<"),
    "==": ("Equal", "!="),
    "!=": ("NotEqual", "=="),
    "+": ("Plus", "-"),
    "-": ("Minus", "+"),
    "*": ("Times", "/"),
    "/": ("Over", "*"),
    "&": ("And", "|"),
    "|": ("Or", "&"),
}
_ASSIGNMENTS = {"+=": ("Add", "-="), "-=": ("Subtract", "+=")}
_SWAPS = {"min": "max", "max": "min", "fma": "fnma", "fnma": "fma", "reduce_min": "reduce_max"}
_SWAPS |= {"reduce_max": "reduce_min", "floor": "ceil", "ceil": "floor"}
_LEFT_OUT = ("min", "max", "abs", "clamp", "nextafter", "sqrt")
_EXCHANGED = ("blend", "select")

_INFIX = re.compile(r"(?<=[\w)\]}]) (<|<=|>|>=|==|!=|\+|-|\*|/|&|\||\+=|-=)(?=[ \n])")
_CALL = re.compile(r"(?<![\w.>:])(?:std::)?(min|max|fma|fnma|reduce_min|reduce_max|floor|ceil|abs|clamp|nextafter|sqrt|blend|select)\(")
_LOGICAL = re.compile(r"(?<=[\w)\]}]) (&&|\|\|)\s+")
_IF = re.compile(r"\bif \(")
_NOT = re.compile(r"(?<![\w)\]])!(?=[\w(])")
_NUMBER = re.compile(r"(?<![\w.<'])(0x[0-9a-f.]+p[+-]?\d+f?|\d+\.\d*(?:e[+-]?\d+)?f?|\d+u?)(?![\w.'>])")
_TRUTH = re.compile(r"\b(true|false)\b")
_MARGIN = re.compile(r"(?<=[+-] )([\w.]*(?:slack|rounding|eps|overhang|resolution|tolerance|margin)\w*|k\w*Slack)(?![\w.(\[])")
_STATEMENT = re.compile(r"(?<=[;{})])\s*?\n[ ]*((?:[\w.:*]|->|\[[\w ()%+*-]*\])+(?:\(| [-+*/&|^]?= )|continue;|break;|\+\+\w+;)")

#: Declarations whose numbers the compiler needs, and statements that change the speed or the text of an error alone.
_FIXED = re.compile(r"(?:\bconstexpr\b(?! (?:bool|\w+) \w+\()|\bstatic_assert\b|\btemplate <|\busing\b|\btypedef\b|\bconcept\b|\balignas\b|\brequires\b|__builtin_shufflevector|__attribute__|\benum\b|\bcase\b|\basm\b)[^;{]*[;{]?")
#: The sizes of arrays in declarations.
_SIZES = re.compile(r"(?:^ +(?!return )(?:const |mutable |thread_local |alignas\(\w+\) )*[\w:]+(?:<[^;=]*>)? \*?\w+|\(&\w*\))(?:\[[^\]]*\])+", re.M)
_UNSEEN = re.compile(r"\b(?:fail|count_step|prefetch\w*|__builtin_prefetch|check_cancelled|pass|reserve|assert)\(|\bcost_? \+= |\bcheckpoint")


def find_places(code: str) -> list[Place]:
    """Return the places of a source, of which `only_code` is given, in their order; some lie within others."""
    skipped = [(m.start(), m.end()) for pattern in (_FIXED, _SIZES) for m in pattern.finditer(code)]
    for m in _UNSEEN.finditer(code):
        end = code.find(";", m.end()) if not m[0].endswith("(") else closing(code, m.end() - 1)
        skipped.append((m.start(), end))
    places = [place for find in _FINDERS for place in find(code)]
    kept = [place for place in places if not any(a < place.end and place.start < b for a, b in skipped)]
    # What begins at the margin is a declaration.
    kept = [place for place in kept if code[code.rfind("\n", 0, place.start) + 1] == " "]
    return sorted(kept, key=lambda place: (place.start, -place.end))


def one_line(text: str) -> str:
    """Return a text with single spaces."""
    return " ".join(text.split())


def around(code: str, start: int, end: int) -> tuple[str, str]:
    """Return the words before and after a range, which tell it from others of its line."""
    before = re.search(r"[\w.\])(\[]*\s*[-+*/=<>&|,?:({]*\s*$", code[max(start - 24, 0) : start])
    after = re.match(r"\s*[\w.(\[:-]*", code[end : end + 24])
    return one_line(before[0] if before else ""), one_line(after[0] if after else "")


def _operators(code: str) -> Iterator[Place]:
    for m in _INFIX.finditer(code):
        known = _OPERATORS.get(m[1]) or _ASSIGNMENTS[m[1]]
        name, others, op = known[0], known[1:], m[1]
        before, after = around(code, m.start(1), m.end(1))
        choices = tuple((f"{before} {op} {after}", f"{before} {other} {after}") for other in others)

        def write(numbers: Sequence[int], inner: Inner, name: str = name, op: str = op) -> str:
            return f"{op} ::mutants::{name}{{{', '.join(map(str, numbers))}}} {op}"

        yield Place(m.start(1), m.end(1), choices, write)


def _calls(code: str) -> Iterator[Place]:
    for m in _CALL.finditer(code):
        end, head, name = closing(code, m.end() - 1), m[0], m[1]
        parts = arguments(code, m.end(), end)
        whole = (m.end(), end)
        # What stands instead: the text before some ranges of the arguments, and the ranges.
        instead: list[tuple[str, list[tuple[int, int]]]] = []
        if name in _SWAPS:
            instead.append((head.replace(name, _SWAPS[name]), [whole]))
        if name in _LEFT_OUT and (len(parts) > 1 or name in ("abs", "sqrt")):
            instead.append(("(", parts[:1]))
        if name in _EXCHANGED and len(parts) == 3:
            instead.append((head, [parts[0], parts[2], parts[1]]))
        text = one_line(code[m.start() : end + 1])
        shown = [f"{before}{', '.join(one_line(code[slice(*part)]) for part in of)})" for before, of in instead]

        def write(numbers: Sequence[int], inner: Inner, instead=instead, original=(head, [whole])) -> str:
            calls = [f"{before}{', '.join(inner(*part) for part in of)})" for before, of in (*instead, original)]
            choices = [f"::mutants::on({number}) ? {call} : " for number, call in zip(numbers, calls, strict=False)]
            return f"({''.join(choices)}{calls[-1]})"

        if instead:
            yield Place(m.start(), end + 1, tuple((text, each) for each in shown), write)


def _operands(code: str) -> Iterator[Place]:
    for m in _LOGICAL.finditer(code):
        end = end_of_operand(code, m.end())
        text = one_line(code[m.start(1) : end])
        neutral = "true" if m[1] == "&&" else "false"

        def write(numbers: Sequence[int], inner: Inner, at=m.end(), end=end, op=m[1]) -> str:
            operand = f"({inner(at, end)})"
            on = f"::mutants::on({numbers[0]})"
            return f"({on} || {operand})" if op == "&&" else f"(!{on} && {operand})"

        yield Place(m.end(), end, ((text, f"{m[1]} {neutral}"),), write)


def _conditions(code: str) -> Iterator[Place]:
    for m in _IF.finditer(code):
        end = closing(code, m.end() - 1)
        condition = one_line(code[m.end() : end])
        if ";" in condition or re.search(r"[\w>&*] \w+ = ", condition):
            continue

        def write(numbers: Sequence[int], inner: Inner, m=m, end=end) -> str:
            return f"!::mutants::on({numbers[0]}) && (::mutants::on({numbers[1]}) || ({inner(m.end(), end)}))"

        choices = ((f"if ({condition})", "if (false)"), (f"if ({condition})", "if (true)"))
        yield Place(m.end(), end, choices, write)


def _tokens(code: str) -> Iterator[Place]:
    for m in _NOT.finditer(code):
        before, after = around(code, m.start(), m.end())
        yield Place(m.start(), m.end(), ((f"{before}!{after}", f"{before}{after}"),), lambda n, _: f"::mutants::on({n[0]}) != !")
    for pattern, other_of in ((_NUMBER, _other_number), (_TRUTH, _other_truth), (_MARGIN, lambda text: f"decltype(+{text})()")):
        for m in pattern.finditer(code):
            other = other_of(m[0])
            before, after = around(code, m.start(), m.end())
            shown = "0" if pattern is _MARGIN else other
            choices = ((f"{before} {m[0]} {after}", f"{before} {shown} {after}"),)

            def write(numbers: Sequence[int], inner: Inner, text=m[0], other=other, plus="+" if pattern is _MARGIN else "") -> str:
                return f"::mutants::constant({numbers[0]}, {other}, {plus}{text})"

            yield Place(m.start(), m.end(), choices, write)


def _other_number(text: str) -> str:
    """Return 0 for 1, 1 for 0, 1 for what is nearly 1, the next whole number, or 0 for another real number."""
    end = "f" if text.endswith("f") and "0x" not in text[:-1] or text.startswith("0x") and text.endswith("f") else ""
    if text.rstrip("u").isdigit():
        value = int(text.rstrip("u"))
        return f"{1 - value if value < 2 else value + 1}{'u' * text.endswith('u')}"
    value = float.fromhex(text.rstrip("f")) if text.startswith("0x") else float(text.rstrip("f"))
    return f"{'1.0' if value == 0.0 or 0.99 < value < 1.01 and value != 1.0 else '0.0'}{end}"


def _other_truth(text: str) -> str:
    return "false" if text == "true" else "true"


def _statements(code: str) -> Iterator[Place]:
    for m in _STATEMENT.finditer(code):
        start = m.start(1)
        end = start
        while end < len(code) and code[end] != ";":
            end = closing(code, end) + 1 if code[end] in "([{" else end + 1
        text = one_line(code[start : end + 1])

        def write(numbers: Sequence[int], inner: Inner, start=start, end=end) -> str:
            return f"{{ if (!::mutants::on({numbers[0]})) {inner(start, end)}; }}"

        if len(text) < 160:
            yield Place(start, end + 1, ((text, ";"),), write)


_FINDERS = (_operators, _calls, _operands, _conditions, _tokens, _statements)
