"""Lines that are thicker than their whole scene: a warning, whichever format they are from."""

from __future__ import annotations

import importlib
import warnings

import numpy as np
import pytest
from support.line_files import hair, tfx
from support.usd_files import curves, usda

import fastlines as fl

POINTS = np.float32([[0, 0, 0], [0.1, 0.2, 0], [0.3, 0.2, 0.1], [0, 0.1, 0.2]])
#: Formats with a radius that are written, and the library that each needs.
WRITTEN = {
    ".hair": None, ".npz": None, ".safetensors": None, ".swc": None, ".txt": None, ".ply": None, ".vtp": None,
    ".usda": "pxr", ".parquet": "pyarrow", ".npz.gz": None,
}  # fmt: skip


def told(read) -> list[str]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        read()
    return [str(one.message) for one in caught if "radius is up to" in str(one.message)]


@pytest.mark.parametrize("extension", WRITTEN)
@pytest.mark.parametrize(("radius", "is_odd"), [(0.5, True), (0.301, True), (0.3, False), (0.01, False)])
def test_written_files(tmp_path, extension, radius, is_odd):
    if WRITTEN[extension]:
        importlib.import_module(WRITTEN[extension])
    path = tmp_path / f"a{extension}"
    radii = np.float32([0.01, radius, 0.01, 0.01])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fl.FileWarning)
        fl.write(path, fl.Lines.from_points(POINTS, [4], radius=radii))
    said = [f"a{extension}: its radius is up to {radius:g}, more than the size of its whole scene, 0.3; if that is a"]
    assert [
        text[text.index(f"a{extension}") :][: len(said[0])] for text in told(lambda: fl.read(path))
    ] == said * is_odd


def test_default_of_a_header_and_other_formats(load):
    thin = POINTS.astype(float)
    files = [
        ("a.hair", hair(bits=2, strands=1, segments=6, thickness=2000), {}),
        ("a.tfx", tfx(3, optional=("thickness",), points=1e-3 * np.arange(18.0).reshape(6, 3)), {}),
        ("a.pbrt", b'Shape "curve" "point3 P" [0 0 0 1 0 0 1 1 0 2 1 0] "float width" 9', {}),
        ("a.csv", b'wkt,r\n"LINESTRING (0 0, 1 0)",2\n', {"radius": "r"}),
    ]
    for name, data, options in files:
        assert len(told(lambda name=name, data=data, options=options: load(data, name, **options))) == 1, name
    pytest.importorskip("pxr")
    prims = curves(thin.tolist(), name="a") + curves(SHORT, name="b", kind="cubic", widths=("constant", [5]))
    assert len(told(lambda: load(usda(prims), "a.usda"))) == 1


SHORT = [(0, 0, 0), (0.1, 0, 0), (0.2, 0, 0), (0.3, 0, 0)]


def test_a_ball_is_no_mistake(load):
    assert told(lambda: load(b"7 1 1 2 3 4 -1", "a.swc")) == []


def test_info_tells(tmp_path, in_own_folder):
    from support.command_line import run

    (tmp_path / "a.hair").write_bytes(hair(bits=2, strands=1, segments=6, thickness=2000))
    with warnings.catch_warnings():
        warnings.simplefilter("default", fl.FileWarning)
        result = run("info", "a.hair")
    assert result.exit_code == 0
    assert result.stderr.startswith("warning: a.hair: its radius is up to 1000, more than the size of its whole scene")


def test_info_tells_of_trees(tmp_path, in_own_folder):
    from support.command_line import run

    fl.build(fl.Lines.from_points(POINTS, [4]).with_radius(9)).save(tmp_path / "a.flt")
    with warnings.catch_warnings():
        warnings.simplefilter("default", fl.FileWarning)
        result = run("info", "a.flt")
        assert result.stderr.startswith("warning: a.flt: its radius is up to 9, more than the size of its whole scene")
        assert "--no-own-radius" in result.stderr
        assert "radius" not in run("info", "a.flt", "--no-own-radius").stderr
