"""Tree files of each format that there has been are read as on the day they were written, bit for bit.

`tests/structure/kept` has a folder for each format: a file for each kind of geometry, with and without a layout, and
what they answered. Files in it never change. A new format, or a new kind of geometry, gets files of its own:
``python tests/structure/test_kept_files.py`` writes those of `trees` that are missing.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines.structure.tree_file import FORMAT

KEPT = Path(__file__).with_name("kept")
ANSWERS = "answers.json"
#: The offset of lines that are far away.
FAR = (5e6, -4e5, 200.0)
#: The columns of the answers that are kept.
COLUMNS = ("offsets", "t", "prim", "part", "u", "distance", "t_out", "strand")
FOLDERS = sorted(folder for folder in KEPT.iterdir() if folder.is_dir())
FILES = [pytest.param(file, id=f"{file.parent.name}-{file.stem}") for file in sorted(KEPT.glob("*/*.flt"))]


def containers() -> dict[str, Any]:
    """Return a container of each kind, of a few primitives, with all that a file keeps of it."""
    rng = np.random.default_rng(64)
    ends = rng.uniform(-1, 1, (6, 2, 3))
    radii, names = rng.uniform(0.02, 0.2, (6, 2)), [f"line {i}" for i in range(6)]
    attributes = {"id": np.arange(6), "name": names}
    lines = fl.Lines.from_segments(ends, strands=[0, 0, 1, 1, 1, 2], attributes=attributes)
    lines = replace(lines, up="z", unit="mm")
    spheres = fl.Spheres.from_centres(ends[:, 0], radii[:, 0])
    boxes = fl.Boxes(np.sort(ends, axis=1))
    return {
        "lines": lines,
        "round-cones": lines.with_radius(radii),
        "lines-far-away": fl.Lines.from_segments(ends + np.array(FAR), offset=FAR),
        "spheres": spheres,
        "curves": fl.Curves.from_bezier(rng.uniform(-1, 1, (3, 4, 3)), radii[:3, [0, 0, 1, 1]], tolerance=0.02),
        "triangles": fl.Triangles(rng.uniform(-1, 1, (6, 3, 3))),
        "boxes": boxes,
        "several-parts": fl.Geometry([lines.with_radius(radii), boxes, spheres]),
    }


def trees() -> Iterator[tuple[str, fl.Tree, bool]]:
    """Return the name of each file, its tree, and whether it has a layout."""
    for name, container in containers().items():
        yield name, fl.build(container), False
        yield f"{name}-with-layout", fl.build(container, limits=fl.Limits(max_leaf_refs=2)), True
    lines = containers()["lines"]
    yield "kd-tree", fl.build(lines, "kd-cl", limits=fl.Limits(max_refs=9)), False
    yield "frame", fl.build(lines, "bvh-d2", frame=[[-3] * 3, [2] * 3]), True


def answers(tree: fl.Tree) -> dict[str, Any]:
    """Return the columns of four queries, by their names."""
    rng = np.random.default_rng(65)
    move = np.array(tree.geometry.offset)
    origins, targets = rng.normal(0, 3, (24, 3)), rng.uniform(-1, 1, (24, 3))
    rays = {"origins": origins + move, "directions": targets - origins, "radius": 0.15}
    found = {
        "all_hits": tree.all_hits(**rays),
        "first_hit at surfaces": tree.first_hit(**rays, at="surface"),
        "nearest": tree.nearest(targets + move, k=2),
        "in_box": tree.in_box(move - 0.5, move + 0.25),
    }
    return {
        f"{query}/{name}": np.asarray(column)
        for query, answer in found.items()
        for name in COLUMNS
        if (column := getattr(answer, name, None)) is not None
    }


@pytest.mark.filterwarnings("ignore::fastlines.QueryWarning")  # a radius does not count for triangles
@pytest.mark.parametrize("path", FILES)
def test_a_file_is_read_and_answers_as_it_did(path: Path) -> None:
    tree = fl.load(path, verify=True)
    tree.validate()
    expected = json.loads(path.with_name(ANSWERS).read_text(encoding="utf-8"))[path.stem]
    found = answers(tree)
    assert [*found] == [*expected]
    for name, column in found.items():
        kept = np.array(expected[name][1], expected[name][0])
        assert (column.dtype, column.shape) == (kept.dtype, kept.shape), name
        assert column.tobytes() == kept.tobytes(), name
    assert np.count_nonzero(found["all_hits/prim"] >= 0) > 1


@pytest.mark.parametrize("path", FILES)
def test_what_lines_say_is_read(path: Path) -> None:
    geometry = fl.load(path).geometry
    if path.stem.startswith(("lines", "round-cones")) and "far" not in path.stem:
        assert (geometry.up, geometry.unit, geometry.strands.tolist()) == ("z", "mm", [0, 0, 1, 1, 1, 2])
        assert geometry.attributes["id"].tolist() == list(range(6))
        assert list(geometry.attributes["name"]) == [f"line {i}" for i in range(6)]


def test_each_kind_has_a_file_of_this_format() -> None:
    folder = KEPT / FORMAT.rpartition(" ")[2]
    assert {path.stem for path in folder.glob("*.flt")} == {name for name, _, _ in trees()}
    assert sum(path.stat().st_size for path in KEPT.rglob("*")) < 150_000 * len(FOLDERS)


def shortest(column: Any) -> list[Any]:
    """Return numbers whose texts are the shortest that give the same bits again."""
    numbers = column.tolist()
    if column.dtype == np.float32:
        numbers = [float(str(number)) for number in column.reshape(-1)]
    return np.reshape(np.array(numbers), column.shape).tolist()


def write_missing(folder: Path) -> None:
    """Write the files of this format that are not there, and their answers."""
    folder.mkdir(parents=True, exist_ok=True)
    to = folder / ANSWERS
    kept = json.loads(to.read_text(encoding="utf-8")) if to.exists() else {}
    for name, tree, has_layout in trees():
        path = folder / f"{name}.flt"
        if not path.exists():
            tree.save(path, layout=has_layout)
            kept[name] = {of: (str(column.dtype), shortest(column)) for of, column in answers(tree).items()}
    rows = ",\n".join(f"{json.dumps(name)}: {json.dumps(columns)}" for name, columns in kept.items())
    to.write_text(f"{{\n{rows}\n}}\n", encoding="utf-8")


if __name__ == "__main__":
    write_missing(KEPT / FORMAT.rpartition(" ")[2])
