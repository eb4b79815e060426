"""The records of entities in the text of a DXF file, and which of them break the rules of the format.

A library that finds one bad entity refuses the whole drawing. So sets of entities are tried, and what fails is halved.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

#: The start of a record: the group code 0, and the kind of the record. No value "0" has a word behind it.
_START = re.compile(rb"^[ \t]*0[ \t]*\r?\n[ \t]*([A-Z][A-Z0-9_]*)[ \t]*\r?$", re.MULTILINE)
_SECTION = re.compile(rb"[ \t]*2[ \t]*\r?\n[ \t]*([A-Z]+)")
#: Records that belong to the entity before, and those that are none.
_PARTS = (b"VERTEX", b"ATTRIB", b"SEQEND")
_FRAMES = (b"SECTION", b"ENDSEC", b"BLOCK", b"ENDBLK", b"EOF")
#: How many sets of entities are tried at most.
_MOST_TRIES = 500


@dataclass(frozen=True)
class Record:
    """An entity, with the records that belong to it: its kind, and where it is in the text."""

    kind: str
    start: int
    stop: int


def without_bad(text: bytes, loads: Callable[[bytes], bool]) -> tuple[bytes, list[Record]]:
    """Return a drawing without the entities that cannot be loaded, and these.

    Parameters
    ----------
    text : bytes
        The file.
    loads : callable
        Takes a drawing, and returns whether it can be loaded.
    """
    header, entities = _records(text)

    def fits(some: Sequence[Record]) -> bool:
        body = b"".join(text[one.start : one.stop] for one in some)
        return loads(header + b"0\nSECTION\n2\nENTITIES\n" + body + b"0\nENDSEC\n0\nEOF\n")

    bad: list[Record] = []
    waiting = [entities] if fits([]) else []
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
    kept, at = bytearray(), 0
    for one in bad:
        kept += text[at : one.start]
        at = one.stop
    return bytes(kept + text[at:]), bad


def _records(text: bytes) -> tuple[bytes, list[Record]]:
    """Return the section of the header, and the entities of the model space and of blocks."""
    starts = list(_START.finditer(text))
    header = b""
    entities: list[Record] = []
    section, section_start = b"", 0
    for i, start in enumerate(starts):
        stop = starts[i + 1].start() if i + 1 < len(starts) else len(text)
        kind = start[1]
        if kind == b"SECTION":
            name = _SECTION.match(text, start.end() + 1)
            section, section_start = name[1] if name else b"", start.start()
        elif kind == b"ENDSEC" and section == b"HEADER":
            header = text[section_start:stop]
        elif section in (b"ENTITIES", b"BLOCKS") and kind not in _FRAMES:
            if kind in _PARTS and entities and entities[-1].stop == start.start():
                first = entities.pop()
                entities.append(Record(first.kind, first.start, stop))
            else:
                entities.append(Record(kind.decode(), start.start(), stop))
    return header, entities
