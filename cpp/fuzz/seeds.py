"""Make the files that fuzzers start from: ``python cpp/fuzz/seeds.py FOLDER`` fills a folder for each fuzzer.

Trees are over few primitives, as small files are mutated and checked more often.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import fastlines as fl
from fastlines.support import container

METHODS = ("best", "bvh-cl", "bvh-ss", "bvh-d2", "kd-cl", "kd-d2", "beams")
rng = np.random.default_rng(1)


def scenes() -> Iterator[tuple[str, fl.Lines]]:
    """Yield lines of all sorts: none, one, a strand, points, lines along axes, radii, far from zero, and an offset."""
    yield "none", fl.Lines.from_segments(np.zeros((0, 2, 3)))
    yield "one", fl.Lines.from_segments([[[0, 0, 0], [1, 2, 3]]])
    yield "strand", fl.Lines.from_strands([np.cumsum(rng.normal(size=(6, 3)), axis=0)])
    yield "points", fl.Lines.from_segments(np.repeat(rng.random((5, 1, 3)), 2, axis=1))
    yield "grid", fl.Lines.from_segments([[[i, 0, 0], [i, 4, 0]] for i in range(4)])
    yield "tubes", fl.Lines.from_segments(rng.random((5, 2, 3)), radius=0.1 * rng.random((5, 2)))
    yield "round", fl.Lines.from_segments(rng.random((3, 2, 3)), radius=0.2)
    yield "far", fl.Lines.from_segments(1e3 + rng.random((4, 2, 3)))
    yield "offset", fl.Lines.from_segments(1e6 + rng.random((2, 2, 3)), offset="auto")


def tree_files(folder: Path) -> None:
    """Save trees over lines by all methods."""
    for i, (name, lines) in enumerate(scenes()):
        for method in (METHODS[i % len(METHODS)], METHODS[(i + 3) % len(METHODS)]):
            fl.build(lines, method).save(folder / f"{name}-{method}.flt")
    moved = fl.build(fl.Lines.from_segments(rng.random((4, 2, 3))), "kd-cl")
    moved.refit(fl.Lines.from_segments(rng.random((4, 2, 3)))).save(folder / "refitted.flt")
    frame = [[-2, -2, -2], [3, 3, 3]]
    fl.build(fl.Lines.from_segments(rng.random((3, 2, 3))), frame=frame).save(folder / "framed.flt")
    for path in folder.glob("*.flt"):
        if path.name != "framed.flt":
            shorten(path)


def shorten(path: Path) -> None:
    """Leave out of the settings what the library does not read, so that more of a file is its arrays."""
    arrays, metadata = container.read(path)
    settings = json.loads(metadata["settings"])
    metadata["settings"] = json.dumps({name: settings[name] for name in ("boxes", "cost")})
    container.write(path, {name: np.array(array) for name, array in arrays.items()}, metadata)


def tree_arrays(folder: Path) -> None:
    """Write the arrays of trees over each kind of primitive, with layouts, as the checks get them."""
    corners = rng.random((4, 3, 3))
    boxes = fl.Boxes(np.stack([corners[:, 0], corners[:, 0] + corners[:, 1]], axis=1))
    kinds: dict[str, fl.Geometry | fl.Lines | fl.Triangles | fl.Boxes] = {
        **{name: lines for name, lines in scenes() if name in ("none", "strand", "points", "tubes")},
        "triangles": fl.Triangles(corners),
        "boxes": boxes,
        "mixed": fl.Geometry([fl.Triangles(corners[:2]), boxes, fl.Lines.from_segments(corners[:, :2], radius=0.1)]),
    }
    for name, geometry in kinds.items():
        for method in ("best", "kd-cl"):
            tree = fl.build(geometry, method)
            nodes, refs = tree.words()
            layout = tree.layout
            arrays = {
                "layout/nodes": layout.nodes,
                "layout/leaves": layout.leaves,
                "nodes": nodes,
                "refs": refs,
                "data": np.ascontiguousarray(geometry.core_rows, np.float32),
                "layout/refs": layout.refs,
            }
            container.write(folder / f"{name}-{method}.flt", arrays, {"boxes": tree.settings.boxes})


def main() -> None:
    """Fill the folders."""
    for name, make in ("tree_file", tree_files), ("tree_arrays", tree_arrays):
        folder = Path(sys.argv[1]) / name
        folder.mkdir(parents=True, exist_ok=True)
        make(folder)
        print(f"{folder}: {json.dumps(sorted(path.name for path in folder.iterdir()))}")


if __name__ == "__main__":
    main()
