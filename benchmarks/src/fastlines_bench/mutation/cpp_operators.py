"""Which places of a C++ source can be mutated, and what is written there instead.

A place is found by its text. The sources are formatted by clang-format, which puts spaces around binary operators and
none inside angle brackets and pointers. What does not compile after all is left out later, by what the compiler says.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

from .cpp_text import arguments, around, closing, end_of_operand, one_line

#: Returns the mutated text of a range, in one line.
Inner = Callable[[int, int], str]
Range = tuple[int, int]


@dataclass(frozen=True)
class Place:
    """A range of the code, what may replace it, and how to write the choice among the numbers of its mutants."""

    start: int
    end: int
    choices: tuple[tuple[str, str], ...]
    write: Callable[[Sequence[int], Inner], str]


#: For each operator the object that takes its place (mutants.hpp), and what it becomes.
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
    "+=": ("Add", "-="),
    "-=": ("Subtract", "+="),
}
#: Functions that become another one, their first argument, or the same with two arguments exchanged.
_SWAPS = {"min": "max", "max": "min", "fma": "fnma", "fnma": "fma", "floor": "ceil", "ceil": "floor"}
_SWAPS |= {"reduce_min": "reduce_max", "reduce_max": "reduce_min"}
_LEFT_OUT = ("min", "max", "abs", "clamp", "nextafter", "sqrt")
_EXCHANGED = ("blend", "select")

_INFIX = re.compile(r"(?<=[\w)\]}]) (<|<=|>|>=|==|!=|\+|-|\*|/|&|\||\+=|-=)(?=[ \n])")
_CALL = re.compile(rf"(?<![\w.>:])(?:std::)?({'|'.join({*_SWAPS, *_LEFT_OUT, *_EXCHANGED})})\(")
_LOGICAL = re.compile(r"(?<=[\w)\]}]) (&&|\|\|)\s+")
_IF = re.compile(r"\bif \(")
_NOT = re.compile(r"(?<![\w)\]])!(?=[\w(])")
_NUMBER = re.compile(r"(?<![\w.<'])(0x[0-9a-f.]+p[+-]?\d+f?|\d+\.\d*(?:e[+-]?\d+)?f?|\d+u?)(?![\w.'>])")
_TRUTH = re.compile(r"\b(true|false)\b")
_MARGIN = re.compile(
    r"(?<=[+-] )([\w.]*(?:slack|rounding|eps|overhang|resolution|tolerance|margin)\w*|k\w*Slack)(?![\w.(\[])"
)
_STATEMENT = re.compile(
    r"(?<=[;{})])\s*?\n[ ]*((?:[\w.:*]|->|\[[\w ()%+*-]*\])+(?:\(| [-+*/&|^]?= )|continue;|break;|\+\+\w+;)"
)

#: Declarations whose numbers the compiler needs.
_FIXED = re.compile(
    r"(?:\bconstexpr\b(?! (?:bool|\w+) \w+\()|\b(?:static_assert|using|typedef|concept|alignas|requires|enum|case)\b"
    r"|\btemplate <|__builtin_shufflevector|__attribute__)[^;{]*[;{]?"
)
#: The sizes of arrays.
_SIZES = re.compile(
    r"(?:^ +(?!return )(?:const |mutable |thread_local |alignas\(\w+\) )*[\w:]+(?:<[^;=]*>)? \*?\w+|\(&\w*\))"
    r"(?:\[[^\]]*\])+",
    re.M,
)
#: What changes the speed, the text of an error or the time to cancel, and nothing else.
_UNSEEN = re.compile(
    r"\b(?:fail|count_step|prefetch\w*|__builtin_prefetch|check_cancelled|pass|reserve|assert)\("
    r"|\bcost_? \+= |\bcheckpoint"
)


def find_places(code: str) -> list[Place]:
    """Return the places of a source, of which `only_code` is given, in their order; some lie within others."""
    skipped = [(m.start(), m.end()) for pattern in (_FIXED, _SIZES) for m in pattern.finditer(code)]
    for m in _UNSEEN.finditer(code):
        end = closing(code, m.end() - 1) if m[0].endswith("(") else code.find(";", m.end())
        skipped.append((m.start(), end))
    places = [place for find in _FINDERS for place in find(code)]
    kept = [place for place in places if not any(a < place.end and place.start < b for a, b in skipped)]
    # What begins at the margin is a declaration.
    kept = [place for place in kept if code[code.rfind("\n", 0, place.start) + 1] == " "]
    return sorted(kept, key=lambda place: (place.start, -place.end))


def _operators(code: str) -> Iterator[Place]:
    for m in _INFIX.finditer(code):
        name, *others = _OPERATORS[m[1]]
        before, after = around(code, m.start(1), m.end(1))
        choices = tuple((f"{before} {m[1]} {after}", f"{before} {other} {after}") for other in others)
        yield Place(m.start(1), m.end(1), choices, partial(_write_operator, name, m[1]))


def _write_operator(name: str, op: str, numbers: Sequence[int], inner: Inner) -> str:
    return f"{op} ::mutants::{name}{{{', '.join(map(str, numbers))}}} {op}"


def _calls(code: str) -> Iterator[Place]:
    for m in _CALL.finditer(code):
        end, head, name = closing(code, m.end() - 1), m[0], m[1]
        parts = arguments(code, m.end(), end)
        original = (head, [(m.end(), end)])
        # What stands instead: the text before some ranges of the arguments, and the ranges.
        instead: list[tuple[str, list[Range]]] = []
        if name in _SWAPS:
            instead.append((head.replace(name, _SWAPS[name]), original[1]))
        if name in _LEFT_OUT and (len(parts) > 1 or name in ("abs", "sqrt")):
            instead.append(("(", parts[:1]))
        if name in _EXCHANGED and len(parts) == 3:
            instead.append((head, [parts[0], parts[2], parts[1]]))
        text = one_line(code[m.start() : end + 1])
        shown = [f"{before}{', '.join(one_line(code[slice(*part)]) for part in of)})" for before, of in instead]
        if instead:
            choices = tuple((text, each) for each in shown)
            yield Place(m.start(), end + 1, choices, partial(_write_call, [*instead, original]))


def _write_call(of: Sequence[tuple[str, Sequence[Range]]], numbers: Sequence[int], inner: Inner) -> str:
    calls = [f"{before}{', '.join(inner(*part) for part in parts)})" for before, parts in of]
    choices = [f"::mutants::on({number}) ? {call} : " for number, call in zip(numbers, calls, strict=False)]
    return f"({''.join(choices)}{calls[-1]})"


def _operands(code: str) -> Iterator[Place]:
    for m in _LOGICAL.finditer(code):
        end = end_of_operand(code, m.end())
        choice = (one_line(code[m.start(1) : end]), f"{m[1]} {'true' if m[1] == '&&' else 'false'}")
        yield Place(m.end(), end, (choice,), partial(_write_operand, m[1], (m.end(), end)))


def _write_operand(op: str, operand: Range, numbers: Sequence[int], inner: Inner) -> str:
    on = f"::mutants::on({numbers[0]})"
    return f"({on} || ({inner(*operand)}))" if op == "&&" else f"(!{on} && ({inner(*operand)}))"


def _conditions(code: str) -> Iterator[Place]:
    for m in _IF.finditer(code):
        end = closing(code, m.end() - 1)
        condition = one_line(code[m.end() : end])
        if ";" not in condition and not re.search(r"[\w>&*] \w+ = ", condition):
            choices = tuple((f"if ({condition})", f"if ({truth})") for truth in ("false", "true"))
            yield Place(m.end(), end, choices, partial(_write_condition, (m.end(), end)))


def _write_condition(condition: Range, numbers: Sequence[int], inner: Inner) -> str:
    return f"!::mutants::on({numbers[0]}) && (::mutants::on({numbers[1]}) || ({inner(*condition)}))"


def _tokens(code: str) -> Iterator[Place]:
    for m in _NOT.finditer(code):
        before, after = around(code, m.start(), m.end())
        yield Place(m.start(), m.end(), ((f"{before}!{after}", f"{before}{after}"),), _write_not)
    for pattern in (_NUMBER, _TRUTH, _MARGIN):
        for m in pattern.finditer(code):
            before, after = around(code, m.start(), m.end())
            if pattern is _MARGIN:
                other, value, original = "0", f"decltype(+{m[0]})()", f"+{m[0]}"
            else:
                other = value = _other_number(m[0]) if pattern is _NUMBER else "false" if m[0] == "true" else "true"
                original = m[0]
            choice = (f"{before} {m[0]} {after}".strip(), f"{before} {other} {after}".strip())
            yield Place(m.start(), m.end(), (choice,), partial(_write_token, value, original))


def _write_not(numbers: Sequence[int], inner: Inner) -> str:
    return f"::mutants::on({numbers[0]}) != !"


def _write_token(value: str, original: str, numbers: Sequence[int], inner: Inner) -> str:
    return f"::mutants::constant({numbers[0]}, {value}, {original})"


def _other_number(text: str) -> str:
    """Return 0 for 1, 1 for 0, 1 for what is nearly 1, the next whole number, or 0 for another real number."""
    if text.rstrip("u").isdigit():
        whole = int(text.rstrip("u"))
        return f"{1 - whole if whole < 2 else whole + 1}{'u' * text.endswith('u')}"
    value = float.fromhex(text.rstrip("f")) if text.startswith("0x") else float(text.rstrip("f"))
    is_near_1 = 0.99 < value < 1.01 and value != 1.0
    return f"{'1.0' if value == 0.0 or is_near_1 else '0.0'}{'f' * text.endswith('f')}"


def _statements(code: str) -> Iterator[Place]:
    for m in _STATEMENT.finditer(code):
        start = end = m.start(1)
        while end < len(code) and code[end] != ";":
            end = closing(code, end) + 1 if code[end] in "([{" else end + 1
        text = one_line(code[start : end + 1])
        if len(text) < 160:
            yield Place(start, end + 1, ((text, ";"),), partial(_write_statement, (start, end)))


def _write_statement(statement: Range, numbers: Sequence[int], inner: Inner) -> str:
    return f"{{ if (!::mutants::on({numbers[0]})) {inner(*statement)}; }}"


_FINDERS = (_operators, _calls, _operands, _conditions, _tokens, _statements)
