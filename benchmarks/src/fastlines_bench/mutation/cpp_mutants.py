"""The mutants of the C++ core, and the mutated copy of its sources."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from .cpp_operators import Place, find_places
from .cpp_text import only_code, without_comments
from .mutant import Mutant, tell_apart

#: The code of traversal, culling, clipping and validation: files and folders below cpp/fastlines.
TARGETS = (
    "kernels/traverse",
    "kernels/intersect",
    "kernels/proximity",
    "layout",
    "query/slabs.hpp",
    "query/binary_traversal.hpp",
    "query/plane_traversal.hpp",
    "query/plane_tree.hpp",
    "query/visited_set.hpp",
    "query/round_cone_entry.hpp",
    "query/proximity/in_box.hpp",
    "query/proximity/all_pairs.hpp",
    "query/proximity/for_each_point.hpp",
    "rays/ray_check.hpp",
    "references",
    "primitives/round_cone_clip.hpp",
    "primitives/segments.hpp",
    "primitives/triangle.hpp",
    "primitives/shapes.hpp",
    "primitives/region.hpp",
    "splits/partition.hpp",
    "splits/retraced_lines.hpp",
    "tree",
)
CORE = Path("cpp/fastlines")


@dataclass(frozen=True)
class Found:
    """A mutant that may be chosen: the place in its file, and which of the place's choices."""

    file: Path
    place: Place
    choice: int
    mutant: Mutant
    last_line: int


def target_files(root: Path) -> list[Path]:
    """Return the files of the targets in a checkout, relative to it."""
    files = []
    for target in TARGETS:
        path = root / CORE / target
        files += sorted(path.rglob("*.hpp")) if path.is_dir() else [path]
    return [file.relative_to(root) for file in files]


def find_mutants(root: Path) -> list[Found]:
    """Return all mutants of the targets, numbered from 1."""
    found: list[Found] = []
    for file in target_files(root):
        found += mutants_of(file, (root / file).read_text(encoding="utf-8"), len(found) + 1)
    tell_apart(each.mutant for each in found)
    return found


def mutants_of(file: Path, text: str, first: int) -> list[Found]:
    """Return the mutants of a source with this text, numbered from the first."""
    found: list[Found] = []
    code, lines = only_code(text), without_comments(text).splitlines()
    name = file.relative_to(CORE).as_posix() if file.is_relative_to(CORE) else file.name
    for place in find_places(code):
        line, last = (code.count("\n", 0, at) + 1 for at in (place.start, place.end))
        for choice, (original, replacement) in enumerate(place.choices):
            mutant = Mutant(first + len(found), name, line, lines[line - 1].strip(), original, replacement)
            found.append(Found(file, place, choice, mutant, last))
    return found


def mutated(text: str, chosen: Collection[Found]) -> tuple[str, set[int]]:
    """Return the text of a file with choices on the switch, and the numbers of the mutants that are in it."""
    numbers: dict[tuple[int, int, tuple[tuple[str, str], ...]], tuple[Place, list[int]]] = {}
    for each in chosen:
        place = each.place
        entry = numbers.setdefault((place.start, place.end, place.choices), (place, [0] * len(place.choices)))
        entry[1][each.choice] = each.mutant.number
    places = sorted(numbers.values(), key=lambda entry: (entry[0].start, -entry[0].end))
    plain, written = without_comments(text), set[int]()

    def write(start: int, end: int, among: list[tuple[Place, list[int]]]) -> str:
        parts, at = [], start
        for i, (place, of) in enumerate(among):
            if place.start < at or place.end > end:
                continue
            parts.append(plain[at : place.start])
            new = place.write(of, partial(write_in_line, among[i + 1 :]))
            # Keep the number of lines, so that messages of the compiler name the line of the source.
            parts.append(new + "\n" * plain.count("\n", place.start, place.end))
            written.update(number for number in of if number)
            at = place.end
        return "".join([*parts, plain[at:end]])

    def write_in_line(among: list[tuple[Place, list[int]]], start: int, end: int) -> str:
        return write(start, end, among).replace("\n", " ")

    return write(0, len(plain), places), written
