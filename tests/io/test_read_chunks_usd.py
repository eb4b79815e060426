"""Chunks of USD files: joined, they are what `fl.read` returns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.line_chunks import check_chunks, check_either, check_error
from support.usd_files import SEVEN, SQUARE, curves, instancer, usda, xform

import fastlines as fl

pytest.importorskip("pxr")

OPTIONS: list[dict[str, Any]] = [{}, {"offset": "auto"}, {"offset": [1000, 0.5, 2]}]


def written(folder: Path, *prims: str, head: str = "", name: str = "a.usda") -> Path:
    (folder / name).write_bytes(usda(*prims, head=head))
    return folder / name


def several() -> list[str]:
    """Return prims of which some lack what others have."""
    return [
        curves(SQUARE + SEVEN, [4, 7], name="a", widths=("constant", [0.25])),
        xform(curves(SEVEN, [3, 4], name="b"), name="moved", move=(100, 0, 0), scale=(2, 2, 2)),
        curves(SEVEN, [2, 5], name="c", widths=("vertex", list(range(7)))),
        curves([], [], name="d"),
    ]


@pytest.mark.parametrize("options", OPTIONS)
def test_linear_curves(tmp_path: Path, options: dict[str, Any]) -> None:
    path = written(tmp_path, *several(), head="upAxis = 'Z'\n metersPerUnit = 0.01")
    for max_segments in (1, 6, 1000):
        chunks = check_chunks(path, max_segments, **options)
    assert len(chunks) == 1
    assert set(chunks[0].attributes) == {"prim"}
    check_chunks(path, 2, prim="/moved", **options)
    assert "no prim" in check_error(path, 2, prim="/nothing")


def test_primvars_that_not_all_prims_have(tmp_path: Path) -> None:
    lines = fl.Lines.from_points(np.arange(30.0).reshape(10, 3), [4, 6], attributes={"age": np.arange(10)})
    fl.write(tmp_path / "a.usda", lines)
    text = (tmp_path / "a.usda").read_text()
    more = curves(SEVEN, [7], name="z")
    (tmp_path / "a.usda").write_text(text + more)
    chunks = check_chunks(tmp_path / "a.usda", 3)
    assert "age" in chunks[0].attributes


@pytest.mark.parametrize("options", OPTIONS)
def test_instances(tmp_path: Path, options: dict[str, Any]) -> None:
    inner = curves(SQUARE, [4], name="a") + curves(SEVEN, [3, 4], name="b")
    check_chunks(written(tmp_path, instancer(inner)), 4, **options)


def test_cubic_curves_are_read_whole(tmp_path: Path) -> None:
    path = written(tmp_path, curves(SEVEN, [7], kind="cubic"))
    assert isinstance(fl.read(path), fl.Curves)
    assert check_chunks(path, 4)
    path = written(tmp_path, curves(SEVEN, [7], kind="cubic"), curves(SEVEN, [7], name="b"))
    with pytest.raises(fl.InputError, match="holds lines and curves; read_chunks returns lines"):
        list(fl.read_chunks(path))


def test_files_without_curves_and_damaged_ones(tmp_path: Path) -> None:
    (chunk,) = check_chunks(written(tmp_path, head="metersPerUnit = 1"))
    assert (len(chunk), chunk.unit) == (0, "m")
    data = written(tmp_path, *several()).read_bytes()
    for n in range(0, len(data), 101):
        (tmp_path / "a.usda").write_bytes(data[:n])
        check_either(tmp_path / "a.usda", 3)


def test_rows_that_are_skipped(tmp_path: Path) -> None:
    points = [*SQUARE[:2], (float("nan"), 0, 0), SQUARE[3]]
    path = written(tmp_path, curves(SEVEN, [7], name="b"), curves(points, [4]))
    check_chunks(path, 2, invalid="skip")
    check_error(path, 2)
