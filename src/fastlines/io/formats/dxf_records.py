"""The parts of the text of a DXF file, and which of them break the rules of the format.

Parts are variables of the header, sections, and the records of entities. A library that finds one bad part refuses the
whole drawing. So sets of parts are tried, and what fails is halved.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

#: The start of a record: the group code 0, and the kind of the record. No value "0" has a word behind it.
_START = re.compile(rb"^[ \t]*0[ \t]*\r?\n[ \t]*([A-Z][A-Z0-9_]*)[ \t]*\r?$", re.MULTILINE)
_SECTION = re.compile(rb"[ \t]*2[ \t]*\r?\n[ \t]*([A-Z]+)")
_VARIABLE = re.compile(rb"^[ \t]*9[ \t]*\r?\n[ \t]*(\$\w+)", re.MULTILINE)
#: Variables without which the others have no meaning, and sections of which no lines are read.
_NEEDED = ("$ACADVER", "$DWGCODEPAGE")
_OTHER_SECTIONS = (b"CLASSES", b"TABLES", b"OBJECTS", b"THUMBNAILIMAGE", b"ACDSDATA")
#: Records that belong to the entity before, and those that are none.
_PARTS = (b"VERTEX", b"ATTRIB", b"SEQEND")
_FRAMES = (b"SECTION", b"ENDSEC", b"BLOCK", b"ENDBLK", b"EOF")
#: How many sets of parts are tried at most.
_MOST_TRIES = 500


@dataclass(frozen=True)
class Record:
    """A part: its kind, and where it is in the text; an entity has the records that belong to it."""

    kind: str
    start: int
    stop: int


def without_bad(text: bytes, loads: Callable[[bytes], bool]) -> tuple[bytes, list[Record]]:
    """Return a drawing without the parts that cannot be loaded, and these.

    Parameters
    ----------
    text : bytes
        The file.
    loads : callable
        Takes a drawing, and returns whether it can be loaded.
    """
    variables, sections, entities = _records(text)

    def body(some: Iterable[Record]) -> bytes:
        return b"".join(text[one.start : one.stop] for one in some)

    def drawing(some: Iterable[Record], others: Iterable[Record] = (), lines: Iterable[Record] = ()) -> bytes:
        header = b"0\nSECTION\n2\nHEADER\n" + body(some) + b"0\nENDSEC\n"
        return header + body(others) + b"0\nSECTION\n2\nENTITIES\n" + body(lines) + b"0\nENDSEC\n0\nEOF\n"

    needed = [one for one in variables if one.kind in _NEEDED]
    rest = [one for one in variables if one.kind not in _NEEDED]
    bad = _failing(rest, lambda some: loads(drawing([*needed, *some])))
    good = [one for one in variables if one not in bad]
    bad += _failing(sections, lambda some: loads(drawing(good, others=some)))
    bad += _failing(entities, lambda some: loads(drawing(good, lines=some)))
    kept, at = bytearray(), 0
    for one in sorted(bad, key=lambda one: one.start):
        kept += text[at : one.start]
        at = one.stop
    return bytes(kept + text[at:]), bad


def text_of(tags: Iterable[tuple[int, Any]]) -> bytes:
    """Return group codes and values, those of a binary file, as text."""
    lines = (f"{code}\n{value.hex() if isinstance(value, bytes) else value}\n" for code, value in tags)
    return "".join(lines).encode("utf-8", "surrogateescape")


def _failing(parts: list[Record], fits: Callable[[Sequence[Record]], bool]) -> list[Record]:
    """Return the parts with which a drawing cannot be loaded."""
    bad: list[Record] = []
    waiting = [parts] if fits([]) else []
    for _ in range(_MOST_TRIES):
        if not waiting:
            break
        some = waiting.pop()
        if not some or fits(some):
            continue
        if len(some) == 1:
            bad += some
        else:
            waiting += [some[len(some) // 2 :], some[: len(some) // 2]]
    return bad


def _records(text: bytes) -> tuple[list[Record], list[Record], list[Record]]:
    """Return the variables of the header, sections without lines, and the entities of the model space and of blocks."""
    starts = list(_START.finditer(text))
    variables: list[Record] = []
    sections: list[Record] = []
    entities: list[Record] = []
    section, section_start = b"", 0
    for i, start in enumerate(starts):
        stop = starts[i + 1].start() if i + 1 < len(starts) else len(text)
        kind = start[1]
        if kind == b"SECTION":
            name = _SECTION.match(text, start.end() + 1)
            section, section_start = name[1] if name else b"", start.start()
            if section == b"HEADER":
                found = list(_VARIABLE.finditer(text, start.end(), stop))
                ends = [other.start() for other in found[1:]] + [stop]
                variables += [Record(one[1].decode(), one.start(), end) for one, end in zip(found, ends, strict=True)]
        elif kind == b"ENDSEC" and section in _OTHER_SECTIONS:
            sections.append(Record(f"section {section.decode()}", section_start, stop))
        elif section in (b"ENTITIES", b"BLOCKS") and kind not in _FRAMES:
            if kind in _PARTS and entities and entities[-1].stop == start.start():
                first = entities.pop()
                entities.append(Record(first.kind, first.start, stop))
            else:
                entities.append(Record(kind.decode(), start.start(), stop))
    return variables, sections, entities
