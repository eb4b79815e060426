"""Reads what the C++ and C headers declare, with their comments.

A comment belongs to the declaration below it, or to the one before it on the same line. A comment above a blank line
titles what follows. The headers must be formatted by clang-format.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from inspect import cleandoc
from pathlib import Path

FOLDER = Path(__file__).parents[2] / "cpp/fastlines"
#: The headers, by Sphinx's name of the language.
HEADERS = {
    "cpp": ("api/ray.hpp", "api/point.hpp", "api/gather.hpp", "api/tree.hpp", "api/acc_tree.hpp"),
    "c": ("fastlines.h", "gather.h"),
}

COMMENT = re.compile(r"(?:[ \t]*//[^\n]*\n)+|/\*.*?\*/\n?", re.DOTALL)
COMMENT_BEHIND = re.compile(r"[ \t]*(?:///<[^\n]*(?:\n[ \t]*///<[^\n]*)*|/\*.*?\*/)", re.DOTALL)
COMMENT_MARKS = re.compile(r"^[ \t]*(?:///?<?|/?\*(?!/)) ?|\s*\*/$", re.MULTILINE)
NOT_CODE = re.compile(r"//[^\n]*|/\*.*?\*/|^#ifdef __cplusplus\n.*?^#endif|^#[^\n]*", re.DOTALL | re.MULTILINE)
NOT_PUBLIC = re.compile(r"\bprivate:.*?(?=\bpublic:|\Z)|\bpublic:", re.DOTALL)
NOT_SHOWN = re.compile(r"friend|~|class|struct|using [^=]*$")  # forward declarations and inherited constructors, too
COMPOUND = re.compile(r"(?:typedef )?(enum class|enum|struct|class) (\w+)(.*)")
FUNCTION = re.compile(r"[^=(]*?(operator[^(]*|\w+)\(")
ALIAS = re.compile(r"using ((\w+) = .*)|typedef (.*?(\w+)(?:\)\(.*\))?)$")
VARIABLE = re.compile(r"(.*?)([*&]?(\w+)(?:\[\d+\])*(?: = .*)?)")


@dataclass
class Declaration:
    """A declaration, or a title, which has no name."""

    kind: str  #: as Sphinx names it
    name: str
    signatures: list[str]  #: several if variables are declared together
    members: list[Declaration] = field(default_factory=list)
    comment: str = ""


def read(path: str) -> list[Declaration]:
    """Return what a header declares."""
    return list(_declarations((FOLDER / path).read_text(encoding="utf-8")))


def _declarations(text: str, separator: str = ";") -> Iterator[Declaration]:
    """Yield what the text of a header, or of a body, declares. The separator of enumerators is a comma."""
    code = NOT_CODE.sub(_blank, text)  # of the same length, so that places in one are places in the other
    at = 0
    while rest := code[at:].lstrip():
        start, comment = len(code) - len(rest), ""
        for found in COMMENT.finditer(text, at, start):
            if re.match(r"[ \t]*\n", text[found.end() :]):
                yield Declaration("title", "", [_uncomment(found[0]).rstrip(".")])
            elif not text[found.end() : start].strip():
                comment = _uncomment(found[0])
        opened, at = _extent(code, start, separator)
        head = " ".join(code[start:opened].replace("FASTLINES_API", "").split())
        body, _, tail = text[opened + 1 : at].rpartition("}")
        if behind := COMMENT_BEHIND.match(text, at):
            comment, at = _uncomment(behind[0]), behind.end()
        if head.startswith("namespace"):
            yield from _declarations(body) if head != "namespace detail" else ()
        elif declaration := _declaration(head, body, tail.strip(" ;"), separator):
            declaration.comment = comment
            yield declaration


def _extent(code: str, start: int, separator: str) -> tuple[int, int]:
    """Return where the body of a declaration opens, or else the declaration ends, and what comes after it."""
    ends_at_body = not re.match(r"(typedef )?(enum|struct|class)\b", code[start:])
    depth, opened = 0, None
    for i in range(start, len(code)):
        depth += (code[i] in "({[") - (code[i] in ")}]")
        if code[i] == "{" and depth == 1:
            opened = i
        if depth == 0 and (code[i] == separator or (code[i] == "}" and ends_at_body)):
            return i if opened is None else opened, i + 1
    return len(code), len(code.rstrip())


def _declaration(head: str, body: str, tail: str, separator: str) -> Declaration | None:
    """Return a declaration, or None if it is not shown. The tail is what stands behind the body."""
    if separator == ",":
        return Declaration("enumerator", head.split()[0], [head])
    if (found := COMPOUND.match(head)) and (body or head.startswith("typedef")):
        kind, name, bases = found.groups()
        if tail not in ("", name):
            raise ValueError(f"{tail!r} is declared together with {name}; declare it apart")
        members = list(_declarations(NOT_PUBLIC.sub(_blank, body), "," if "enum" in kind else ";"))
        return Declaration(kind.replace(" ", "-"), name, [name + bases if body else name], members)
    if NOT_SHOWN.match(head):
        return None
    if found := ALIAS.match(head):
        return Declaration("type", found[2] or found[4], [found[1] or found[3]])
    if found := FUNCTION.match(head):
        return Declaration("function", found[1], [re.sub(r"(\)[\w ]*?) : .*", r"\1", head)])  # without initializers
    first, *others = re.split(r", (?![^<(]*[>)])", head)
    if found := VARIABLE.fullmatch(first):
        return Declaration("member", found[3], [first, *(found[1] + other for other in others)])
    raise ValueError(f"docs/_ext/headers.py cannot read {head!r}")


def _blank(match: re.Match[str]) -> str:
    return re.sub(r"[^\n]", " ", match[0])


def _uncomment(comment: str) -> str:
    return cleandoc(COMMENT_MARKS.sub("", comment))
