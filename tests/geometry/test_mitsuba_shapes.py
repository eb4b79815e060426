"""Lines and curves from shapes and scenes of Mitsuba, beside what Mitsuba itself hits."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines.errors import FileWarning, InputError

#: Two curves, of 5 and 4 points.
STRANDS = [
    [[0, 0, 0, 0.1], [1, 0, 0, 0.2], [2, 1, 0, 0.3], [3, 1, 0, 0.2], [4, 0, 1, 0.1]],
    [[0, 5, 0, 0.1], [1, 5, 0, 0.1], [2, 5, 1, 0.2], [3, 5, 2, 0.1]],
]
LINEAR, SPLINE = "linearcurve", "bsplinecurve"


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "hair.txt"
    path.write_text("\n\n".join("\n".join(" ".join(map(str, row)) for row in strand) for strand in STRANDS))
    return str(path)


@pytest.fixture
def mi() -> Any:
    module = pytest.importorskip("mitsuba")
    module.set_variant("scalar_rgb")
    return module


def shape(mi: Any, kind: str, file: str) -> Any:
    return mi.load_dict({"type": kind, "filename": file})


def test_shapes_are_what_their_file_holds(mi: Any, file: str) -> None:
    lines, read = fl.lines(shape(mi, LINEAR, file)), fl.read(file)
    for name in ("segments", "strands", "radius"):
        np.testing.assert_array_equal(getattr(lines, name), getattr(read, name))
    curves, read = fl.curves(shape(mi, SPLINE, file), tolerance=0.01), fl.read(file, basis="bspline")
    for name in ("control", "strands", "radius"):
        np.testing.assert_array_equal(getattr(curves, name), getattr(read, name))
    assert curves.tolerance == 0.01
    assert len(fl.build(shape(mi, LINEAR, file)).geometry) == 7


@pytest.mark.parametrize("kind", [LINEAR, SPLINE])
def test_mitsuba_hits_the_same(mi: Any, tmp_path: Path, kind: str) -> None:
    path = tmp_path / "even.txt"  # where radii differ, Mitsuba's splines sweep discs, and ours balls
    path.write_text("\n".join(f"{x} {y} {z} 0.2" for x, y, z, _ in STRANDS[0]))
    scene = mi.load_dict({"type": "scene", "hair": {"type": kind, "filename": str(path)}})
    geometry = fl.lines(scene) if kind == LINEAR else fl.curves(scene, tolerance=1e-5)
    rng = np.random.default_rng(1)
    origins = np.column_stack([rng.uniform(0.8, 3.2, 200), rng.uniform(-0.3, 1.3, 200), np.full(200, 8.0)])
    hits = fl.build(geometry).first_hit(origins, [0, 0, -1], at="surface")
    found = np.array([scene.ray_intersect(mi.Ray3f(list(origin), [0, 0, -1])).t for origin in origins.tolist()])
    # Where segments turn, Mitsuba's linear curves have a gap, and ours are round.
    assert (hits.hit >= np.isfinite(found)).all()
    both = np.isfinite(found)
    assert both.sum() > 40
    near = np.abs(hits.t[both] - found[both]) < 1e-4
    assert near.all() if kind == SPLINE else near.mean() > 0.9


def test_a_scene(mi: Any, file: str) -> None:
    parts = {
        "a": {"type": "sphere"},
        "b": {"type": LINEAR, "filename": file},
        "c": {"type": SPLINE, "filename": file},
        "d": {"type": LINEAR, "filename": file},
    }
    scene = mi.load_dict({"type": "scene", **parts})
    with pytest.warns(FileWarning, match=r"1 Sphere, 1 BSplineCurve; fl\.curves\(scene\) takes the BSplineCurve"):
        lines = fl.lines(scene)
    np.testing.assert_array_equal(lines.attributes["shape"], np.repeat([1, 3], 7))
    np.testing.assert_array_equal(lines.strands, np.repeat([0, 1, 2, 3], [4, 3, 4, 3]))
    with pytest.warns(FileWarning, match="shapes of the scene other than BSplineCurve are not read: 1 Sphere, 2 Linea"):
        curves = fl.curves(scene)
    np.testing.assert_array_equal(curves.attributes["shape"], [2, 2, 2])
    with pytest.warns(FileWarning, match="1 Sphere"):
        assert len(fl.lines(mi.load_dict({"type": "scene", "a": parts["a"]}))) == 0


def test_what_is_no_line(mi: Any, file: str) -> None:
    with pytest.raises(InputError, match=r"lines are a shape BSplineCurve of Mitsuba; fl\.curves\(shape\) makes"):
        fl.lines(shape(mi, SPLINE, file))
    with pytest.raises(InputError, match="lines are a shape Sphere of Mitsuba; expected a linearcurve or a scene"):
        fl.lines(mi.load_dict({"type": "sphere"}))
    with pytest.raises(InputError, match="curves are a shape LinearCurve of Mitsuba; expected a bsplinecurve of Mits"):
        fl.curves(shape(mi, LINEAR, file))


def test_curves_of_something_else() -> None:
    for given in (None, STRANDS, SimpleNamespace(shapes=1)):
        with pytest.raises(InputError, match=r"expected a bsplinecurve of Mitsuba or a scene: fl\.lines takes others"):
            fl.curves(given)
