"""Writing: which objects and paths are refused, with what to do instead."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import fastlines as fl
from fastlines.errors import InputError

LINES = fl.Lines.from_strands(np.arange(12.0).reshape(2, 2, 3))


def test_arguments_in_the_wrong_order(tmp_path):
    for path in ("a.npz", tmp_path / "a.npz"):
        with pytest.raises(InputError, match=r"a\.npz', the name of a file; the name comes first: fl\.write\(path, l"):
            fl.write(LINES, path)


def test_a_tree_is_not_written(tmp_path):
    with pytest.raises(InputError, match=r"a\.npz: lines are a Tree; what it is over is tree\.geometry"):
        fl.write(tmp_path / "a.npz", fl.build(LINES))
    for name in ("a.flt", "a.flt.gz"):
        with pytest.raises(
            InputError, match=r"is the name of a tree.*; fl\.build\(lines\)\.save\(path\) builds a tree"
        ):
            fl.write(tmp_path / name, LINES)
    assert not list(tmp_path.iterdir())


def test_a_folder_is_not_written(tmp_path):
    (tmp_path / "a.npz").mkdir()
    for folder in (tmp_path, str(tmp_path / "a.npz")):
        with pytest.raises(IsADirectoryError, match="is a directory; expected the name of a file to write"):
            fl.write(folder, LINES)


def test_a_geometry_names_its_parts_and_what_holds_them(tmp_path):
    curves = fl.Curves.from_bezier(np.eye(4, 3)[None])
    with pytest.raises(InputError) as caught:
        fl.write(tmp_path / "a.swc", fl.Geometry([LINES, curves]))
    assert str(caught.value) == (
        f"{tmp_path / 'a.swc'}: this is a Geometry of part 0 (2 segments), part 1 (1 curve), and such files hold one "
        "part; write all parts to one of .usd, .usda, .usdc, .usdz, or one by itself, as in fl.write(path, "
        "geometry.parts[0])"
    )
    with pytest.raises(InputError, match="this is a Geometry of no parts"):
        fl.write(tmp_path / "a.swc", fl.Geometry([]))


def test_an_extension_that_is_not_written_names_the_nearest_that_is(tmp_path):
    with pytest.raises(InputError, match=r"'\.npzz' are not written; did you mean '\.npz'\? known: \.parquet"):
        fl.write(tmp_path / "a.npzz", LINES)
    with pytest.raises(InputError, match=r"'\.tfx' are not written; known: \.parquet"):  # it is read
        fl.write(tmp_path / "a.tfx", LINES)


def test_a_missing_tree_is_told_as_other_missing_files_are(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no such file; check the path \(the working directory is") as caught:
        fl.load(tmp_path / "gone.flt")
    assert Path(caught.value.filename) == tmp_path / "gone.flt"
