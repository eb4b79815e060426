"""Damage done to files by someone who knows their format: words of texts, members of archives, sections of trees."""

from __future__ import annotations

import io
import json
import math
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Sequence
from random import Random
from typing import Any

from support.text_files import NUMBERS

#: Changes bytes as the fuzzer does: takes the bytes and the most that may come of them.
Basic = Callable[[bytes, int], bytes]
#: Changes a file: takes its bytes, the most that may come of them, random numbers, and the basic change.
Mutator = Callable[[bytes, int, Random, Basic], bytes]

_NUMBER = re.compile(rb"[-+]?[0-9][-+.0-9eE]*")


#: Words of four bytes at the ends of ranges: of whole numbers in both byte orders, and of floats.
_WORDS = [
    *(
        n.to_bytes(4, order, signed=n < 0)
        for n in (0, 1, 2, 255, -1, -(2**31), 2**31 - 1)
        for order in ("little", "big")
    ),
    *(struct.pack("<f", x) for x in (math.nan, math.inf, -math.inf, -1.0, 1e38, 1e-45)),
]


def binary(data: bytes, most: int, random: Random, basic: Basic) -> bytes:
    """Change any bytes, or a word of four, which leaves everything in its place."""
    if len(data) < 4 or random.randrange(2):
        return basic(data, most)
    at = random.randrange(len(data) - 3) & random.choice((-1, -2, -4))
    old = int.from_bytes(data[at : at + 4], "little")
    near = ((old + random.choice((-1, 1, 3, 256))) % 2**32).to_bytes(4, "little")
    return data[:at] + random.choice((near, data[at : at + 4][::-1], *_WORDS)) + data[at + 4 :]


def text(words: Sequence[bytes], ends: bytes = b"\n") -> Mutator:
    """Return a mutator of texts with these words, whose lines end at one of some characters."""

    def mutate(data: bytes, most: int, random: Random, basic: Basic) -> bytes:
        match random.randrange(6):
            case 0 if numbers := list(_NUMBER.finditer(data)):
                start, stop = random.choice(numbers).span()
                data = data[:start] + random.choice(NUMBERS) + data[stop:]
            case 1 if words:
                at = random.randrange(len(data) + 1)
                data = data[:at] + random.choice(words) + data[at:]
            case 2:
                data = _moved(data, random, ends)
            case _:
                return basic(data, most)
        return data[:most]

    return mutate


def _moved(data: bytes, random: Random, ends: bytes) -> bytes:
    """Leave out a line, repeat it, or take it elsewhere."""
    lines = re.split(b"(?<=[" + re.escape(ends) + b"])", data)
    i, j = random.randrange(len(lines)), random.randrange(len(lines))
    match random.randrange(4):
        case 0:
            del lines[i]
        case 1:
            lines.insert(j, lines[i])
        case 2:
            lines[i], lines[j] = lines[j], lines[i]
        case _:
            lines[i:i] = lines[i : i + random.randrange(1, 5)]
    return b"".join(lines)


def archive(names: Sequence[str]) -> Mutator:
    """Return a mutator of archives by zip: members change, go, come, or are named otherwise; checksums fit again."""

    def mutate(data: bytes, most: int, random: Random, basic: Basic) -> bytes:
        if random.randrange(8) == 0:
            return basic(data, most)
        try:
            with zipfile.ZipFile(io.BytesIO(data)) as found:
                members = [(info.filename, found.read(info), info.compress_type) for info in found.infolist()]
        except Exception:  # it is damaged already
            return basic(data, most)
        i = random.randrange(len(members) + 1)
        name, content, method = members[i] if i < len(members) else (random.choice(names), b"", zipfile.ZIP_STORED)
        match random.randrange(8):
            case 0:
                members[i : i + 1] = []
            case 1:
                members[i : i + 1] = [(random.choice(names), content, method)]
            case 2:
                members[i : i + 1] = [(name, content, random.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)))]
            case 3 if members:
                members.insert(i, random.choice(members))
            case _:
                members[i : i + 1] = [(name, binary(content, most, random, basic), method)]
        made = io.BytesIO()
        with zipfile.ZipFile(made, "w") as archive:
            for name, content, method in members:
                archive.writestr(zipfile.ZipInfo(name), content, method)
        return made.getvalue() if len(made.getvalue()) <= most else data

    return mutate


def split_tree(data: bytes) -> tuple[dict[str, Any], list[bytes]]:
    """Return the header of a tree file, and the bytes of its sections but for the checksums."""
    length = int.from_bytes(data[:8], "little")
    header, body = json.loads(data[8 : 8 + length]), data[8 + length :]
    sections = [entry["data_offsets"] for name, entry in header.items() if name not in ("__metadata__", "crc32")]
    return header, [body[start:stop] for start, stop in sections]


def joined_tree(header: dict[str, Any], sections: Sequence[bytes], *, moved: bool = True) -> bytes:
    """Return a tree file with true checksums; where sections moved, their places are made right too."""
    entries = {name: entry for name, entry in header.items() if name not in ("__metadata__", "crc32")}
    at = 0
    for entry, section in zip(entries.values(), sections, strict=True):
        if moved:
            entry["data_offsets"] = [at, at + len(section)]
        at += len(section)
    n = 1 + len(sections)
    end = {"dtype": "U8", "shape": [n, 4], "data_offsets": [at, at + 4 * n]}
    words = json.dumps({"__metadata__": header.get("__metadata__", {}), **entries, "crc32": end}).encode()
    words += b" " * (-(8 + len(words)) % 64)
    head = len(words).to_bytes(8, "little") + words
    sums = b"".join(zlib.crc32(part).to_bytes(4, "little") for part in (head, *sections))
    return b"".join([head, *sections, sums])


def tree(data: bytes, most: int, random: Random, basic: Basic) -> bytes:
    """Change a section or a fact of a tree file, and make its checksums right again, but for one time in eight."""
    if random.randrange(8) == 0:
        return basic(data, most)
    try:
        header, sections = split_tree(data)
        names = [name for name in header if name not in ("__metadata__", "crc32")]
        facts = header.get("__metadata__", {})
        i = random.randrange(len(names))
        match random.randrange(6):
            case 0 if facts:
                fact = random.choice(list(facts))
                facts[fact] = basic(facts[fact].encode(), 2000).decode("latin-1")
            case 1:
                entry = json.loads(basic(json.dumps(header[names[i]]).encode(), 500))
                header[names[i]] = {**header[names[i]], **entry}
            case 2:
                _resize(header[names[i]], sections, i, random)
            case 3:
                header[random.choice((names[i] + "x", *names))] = header.pop(names[i])
                sections.append(sections.pop(i))
                return joined_tree(header, sections[: len(header) - 2], moved=True)
            case _:
                sections[i] = _changed(sections[i], random, basic)
        made = joined_tree(header, sections, moved=random.randrange(16) != 0)
        return made if len(made) <= most else data
    except (ValueError, TypeError, KeyError, AttributeError, IndexError):  # it is damaged already
        return basic(data, most)


def _changed(section: bytes, random: Random, basic: Basic) -> bytes:
    """Change the bytes of a section, and keep their number."""
    made = binary(section, len(section), random, basic)[: len(section)] if section else section
    return made + section[len(made) :]


def _resize(entry: dict[str, Any], sections: list[bytes], i: int, random: Random) -> None:
    """Leave out or repeat a row of a section."""
    n = entry["shape"][0]
    size = len(sections[i]) // n if n else 0
    at = size * random.randrange(n + 1)
    if random.randrange(2):
        sections[i], entry["shape"][0] = sections[i][:at] + sections[i][at + size :], n - (at < len(sections[i]))
    elif at < len(sections[i]):
        sections[i], entry["shape"][0] = sections[i][: at + size] + sections[i][at:], n + 1
