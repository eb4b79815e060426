"""AOVs: the numbers of one ray through the centre of each pixel, and the EXR that holds them."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.rendering import AOVS, depth_image
from fastlines.rendering.shading import aovs

STRANDS = fl.Lines.from_strands([[[-1, y, 0], [0, y, 0.3], [1, y + 0.2, 0]] for y in np.linspace(-1, 1, 20)])
CAMERA = fl.Camera(origin=(0, 0, 6), target=(0, 0, 0))


def drawn(geometry=STRANDS, radius=0.03, size=40, **options):
    options = {"look": "id", "samples": 1} | options
    return fl.render(geometry, CAMERA, width=size, height=size, radius=radius, aovs=True, **options)


def test_they_are_what_the_ray_of_each_pixel_hits():
    tree = fl.build(STRANDS)
    found = drawn(tree).aovs
    hits = tree.first_hit(*CAMERA.rays(40, 40), 0.03, at="surface")
    assert list(found) == list(AOVS)
    assert (found["depth"].ravel() == hits.t).all()
    assert (found["id"].ravel() == hits.strand).all()
    assert (found["prim"].ravel() == hits.prim).all()
    for name, values in (("position", hits.points()), ("normal", hits.normals()), ("tangent", hits.tangents())):
        assert np.array_equal(found[name].reshape(-1, 3), values.astype(np.float32), equal_nan=True), name
    missed = ~hits.hit.reshape(40, 40)
    assert missed.any()
    assert np.isnan(found["normal"][missed]).all()
    assert np.isinf(found["depth"][missed]).all()


def test_thin_lines_are_those_within_half_a_pixel():
    line = fl.Lines.from_segments([[[-9, 0.004, 0], [9, 0.004, 0]]])
    found = drawn(line, radius=1e-5, size=41).aovs
    assert (found["id"][20] == 0).all()
    assert (np.delete(found["id"], 20, axis=0) == -1).all()
    assert np.abs(found["normal"][20, 20] - (0, 0, 1)).max() < 1e-3
    assert np.abs(np.abs(found["tangent"][20]) - (1, 0, 0)).max() < 1e-3
    seen = found["position"][20]
    assert np.abs(np.sqrt(((seen - CAMERA.origin) ** 2).sum(axis=1)) - found["depth"][20]).max() < 1e-5


def test_other_shapes_have_no_tangents_and_parts_count_on():
    balls = fl.Spheres.from_centres([[-0.5, 0, 0], [0.5, 0, 0]], radius=0.3)
    floor = fl.Triangles([[[-9, -9, -1], [9, -9, -1], [0, 9, -1]]])
    found = drawn(fl.Geometry([floor, balls]), radius=0.0).aovs
    assert np.unique(found["prim"]).tolist() == [0, 1, 2]
    assert np.isnan(found["tangent"][0, 0]).all()
    assert found["normal"][0, 0].tolist() == [0, 0, 1]


def test_they_do_not_depend_on_bands(monkeypatch):
    whole = drawn().aovs
    monkeypatch.setattr(aovs, "MAX_RAYS", 100)
    for name, values in drawn().aovs.items():
        assert np.array_equal(values, whole[name], equal_nan=True)


def test_depths_agree_with_the_depth_image():
    tree = fl.build(STRANDS.with_radius(0.03))
    assert (drawn(tree, radius=None).aovs["depth"] == depth_image(tree, CAMERA, 40, 40)).all()


def test_an_empty_tree_has_empty_aovs():
    found = drawn(fl.Lines.from_segments(np.zeros((0, 2, 3)))).aovs
    assert (found["id"] == -1).all()
    assert np.isinf(found["depth"]).all()


def test_one_exr_has_them_all(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    picture = drawn(look="tube", exposure=1.0)
    picture.save(tmp_path / "a.exr")
    with openexr.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    vectors = [f"{name}.{axis}" for name in ("N", "P", "tangent") for axis in "XYZ"]
    assert sorted(channels) == sorted([*"RGBAZ", "id", "prim", *vectors])
    assert channels["G"] == pytest.approx(2 * picture.light[..., 1], rel=1e-3, abs=1e-4)
    assert channels["A"] == pytest.approx(picture.alpha, rel=1e-3, abs=1e-4)
    assert (channels["Z"] == picture.aovs["depth"]).all()
    assert np.array_equal(channels["P.Y"], picture.aovs["position"][..., 1], equal_nan=True)
    assert channels["id"].dtype == np.uint32
    assert (channels["id"].astype(np.int64) == picture.aovs["id"] % 2**32).all()
    assert channels["id"].max() == 2**32 - 1


def test_an_exr_without_aovs_is_light_and_alpha(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    picture = fl.render(STRANDS, CAMERA, width=8, height=8, radius=0.1, samples=1)
    picture.save(tmp_path / "a.exr")
    with openexr.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        assert sorted(file.channels()) == ["A", "B", "G", "R"]
    with pytest.raises(fl.InputError, match="always transparent"):
        picture.save(tmp_path / "a.exr", transparent=True)
    with pytest.raises(fl.InputError, match=r"\.jpg"):
        picture.save(tmp_path / "a.jpg")
