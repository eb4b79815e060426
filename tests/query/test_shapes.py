"""Triangles, boxes, curves, several kinds in one tree, and primitives of one's own: what answers say."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same
from support.builds import Balls

import fastlines as fl
from fastlines.query.queries import QUERIES

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def mesh() -> fl.Triangles:
    uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    labels = {"label": [0, 1, 2, 3], "uv": uv}
    return fl.Triangles.from_mesh(SQUARE, [[0, 1, 2], [0, 2, 3]], attributes=labels, face_attributes={"face": [7, 8]})


def scene() -> fl.Geometry:
    """A square at z = 0, a strand above it, a ball above that, and a box beside."""
    strand = fl.Lines.from_points([[0, 0.5, 1], [0.5, 0.5, 1], [1, 0.5, 1]], [3], radius=[0.1, 0.1, 0.2])
    ball = fl.Spheres.from_centres([[0.5, 0.5, 3]], radius=0.25)
    return fl.Geometry([mesh(), strand, ball, fl.Boxes([[[2, 0, 0], [3, 1, 1]]])])


DOWN = [0, 0, -1]


def test_a_triangle_is_hit_where_it_is_crossed() -> None:
    tree = fl.build(mesh())
    hits = tree.first_hit([[0.75, 0.25, 2], [0.25, 0.75, -3], [2, 2, 2]], [DOWN, [0, 0, 2], DOWN], radius=0.5)
    assert hits.prim.tolist() == [0, 1, -1]
    assert hits.t.tolist() == [2, 1.5, np.inf]
    assert hits.distance.tolist() == [0, 0, np.inf]
    # The normal is on the side that the ray comes from.
    assert hits.normals()[:2].tolist() == [[0, 0, 1], [0, 0, -1]]
    assert np.isnan(hits.tangents()).all()
    np.testing.assert_allclose(hits.sample("uv")[:2], [[0.75, 0.25], [0.25, 0.75]])
    assert hits.sample("face")[:2].tolist() == [7, 8]
    assert hits.sample("label")[:2].tolist() == [1, 3]  # of the nearest corner
    assert hits.strand.tolist() == [-1, -1, -1]
    with pytest.raises(fl.InputError, match="is not an attribute of <Triangles: 2 triangles, face, label, uv>"):
        hits.sample("uw")


def test_a_ray_along_the_diagonal_meets_both_triangles() -> None:
    tree = fl.build(mesh())
    assert tree.count_hits([0.5, 0.5, 1], DOWN) == 2
    assert tree.count_hits([0.5, 0.25, 1], DOWN) == 1


@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_shadow_rays_leave_a_mesh(offset: float) -> None:
    """Rays that start outside a closed mesh, at a point of it, and leave it, do not hit it."""
    rng = np.random.default_rng(4)
    t = np.linspace(0, 2 * np.pi, 60)
    ring, height = np.stack([np.cos(t), np.sin(t)], axis=1), np.linspace(-1, 1, 30)
    vertices = np.stack([np.column_stack([ring * np.sqrt(1 - h * h), np.full(60, h)]) for h in height])
    index = np.arange(30 * 60).reshape(30, 60)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)]).reshape(-1, 3)
    tree = fl.build(fl.Triangles.from_mesh((vertices.reshape(-1, 3) + offset).astype(np.float32), faces))
    origins = rng.normal(size=(2000, 3))
    origins = (3 * origins / np.linalg.norm(origins, axis=1)[:, None] + offset).astype(np.float32)
    hits = tree.first_hit(origins, (offset - origins).astype(np.float32), at="surface")
    assert hits.hit.all()
    points, normals = hits.points(outside=True)[hits.hit], hits.normals()[hits.hit]
    away = normals + 0.9 * rng.normal(size=normals.shape) / 3
    away = away[good := (away * normals).sum(axis=1) > 0.3]
    assert not tree.any_hit(points[good], away).any()


def test_only_what_needs_rays_asks_for_them() -> None:
    """Hits share the arrays of rays; tangents and values of whole primitives do not read them."""
    tree = fl.build(fl.Geometry([mesh(), fl.Lines.from_segments([[[0, 0, 1], [1, 0, 1]]], radius=[0.1])]))
    origins = np.array([[0.5, 0, 5], [0.5, 0.5, 5]], np.float32)
    hits = tree.first_hit(origins, DOWN, at="surface")
    origins[:] = 7
    assert hits.tangents()[0].tolist() == [1, 0, 0]
    assert np.isnan(hits.sample("face")[0])
    assert hits.sample("face")[1] in (7, 8)
    with pytest.raises(fl.InputError, match="have changed"):
        hits.sample("uv")
    with pytest.raises(fl.InputError, match="have changed"):
        hits.points()


def test_boxes_are_solid() -> None:
    tree = fl.build(fl.Boxes([[[0, 0, 0], [1, 1, 2]]], attributes={"id": [5]}))
    origins, directions = [[0.5, 0.5, 5], [-1, 0.5, 0.5], [0.5, 0.5, 1]], [DOWN, [1, 0, 0], [0, 1, 0]]
    hits = tree.first_hit(origins, directions, at="surface")
    assert hits.t.tolist() == [3, 1, 0]
    assert hits.t_out is not None
    assert hits.t_out.tolist() == [5, 2, 0.5]
    assert hits.normals()[:2].tolist() == [[0, 0, 1], [-1, 0, 0]]
    assert hits.sample("id").tolist() == [5, 5, 5]


@pytest.mark.parametrize("kind", ["plate", "square"])
def test_points_and_normals_are_those_of_float64(kind: str) -> None:
    """Rays that come from a thousand times the size of what they hit."""
    rng = np.random.default_rng(0)
    shapes = {"plate": fl.Boxes([[[0, 0, -1e-3], [1, 1, 0]]]), "square": mesh()}
    tree = fl.build(shapes[kind])
    target = np.column_stack([rng.uniform(0.1, 0.9, (2000, 2)), np.zeros(2000)])
    origins = (target + np.array([3.0, 2.0, 1000.0])).astype(np.float32)
    hits = tree.first_hit(origins, (target - origins).astype(np.float32) / 1000, at="surface")
    assert hits.hit.all()
    assert (hits.normals() == [0, 0, 1]).all()
    assert np.abs(hits.points()[:, 2]).max() < 1e-9
    assert not tree.any_hit(hits.points(outside=True), [0, 0, 1]).any()


@pytest.mark.parametrize("far", [[[1, 1, 1], [1, 1, 1]], [[5, 5, 5], [6, 6, 6]]])
def test_a_box_holds_its_faces(far: Any) -> None:
    """A ray in the plane of a face is inside, whatever else is in the scene."""
    tree = fl.build(fl.Boxes([[[0, 0, 0], [1, 1, 1]], far]))
    hits = tree.first_hit([[0, 0.5, -5], [1, 0.5, -5], [0, 0, -5]], [0, 0, 1], at="surface")
    assert hits.prim.tolist() == [0, 0, 0]
    assert hits.t_out is not None
    np.testing.assert_allclose(hits.t, 5, rtol=1e-6)
    np.testing.assert_allclose(hits.t_out, 6, rtol=1e-6)
    plates = fl.build(fl.Boxes([[[0, 0, 0], [1, 0, 1]], [[0, 0, 4], [1, 0, 5]]]))
    assert plates.all_hits([0.5, 0, -5], [0, 0, 1]).prim.tolist() == [0, 1]


def test_hits_say_which_part_and_which_primitive() -> None:
    geometry = scene()
    tree = fl.build(geometry)
    origins = [[0.5, 0.5, 9], [0.9, 0.5, 9], [0.1, 0.9, 9], [2.5, 0.5, 9], [9, 9, 9]]
    hits = tree.first_hit(origins, DOWN, at="surface")
    assert hits.part is not None
    assert hits.part.tolist() == [2, 1, 0, 3, -1]
    assert hits.prim.tolist() == [0, 1, 1, 0, -1]
    assert hits.row.tolist() == hits.prim.tolist()
    assert hits.strand.tolist() == [-1, 0, -1, -1, -1]
    assert hits.prim_number.tolist() == [4, 3, 1, 5, -1]
    np.testing.assert_allclose(hits.points()[:4, 2], [3.25, 1 + 0.18 / np.sqrt(0.96), 0, 1], atol=0.01)
    np.testing.assert_allclose(hits.normals()[[0, 2, 3]], [[0, 0, 1]] * 3, atol=1e-6)
    tangents = hits.tangents()
    assert tangents[1].tolist() == [1, 0, 0]
    assert np.isnan(tangents[[0, 2, 3, 4]]).all()
    uv = hits.sample("uv")
    np.testing.assert_allclose(uv[2], [0.1, 0.9], atol=1e-6)
    assert np.isnan(uv[[0, 1, 3, 4]]).all()
    assert hits.sample("radius")[0] == 0.25
    with pytest.raises(fl.InputError, match="is not an attribute of any part"):
        hits.sample("colour")
    assert tree.first_hit([[9, 9, 9]], DOWN, at="surface").sample("uv").shape == (1, 2)
    everything = tree.all_hits(origins, DOWN, at="surface")
    assert everything.part is not None
    assert everything.part[everything.of(0)].tolist() == [2, 1, 1, 0, 0]
    merged = tree.all_hits(origins, DOWN, at="surface", merge="strand")
    assert merged.part is not None
    assert merged.part[merged.of(0)].tolist() == [2, 1, 0, 0]
    back = pickle.loads(pickle.dumps(hits))
    assert (back.part == hits.part).all()
    assert (back.strand == hits.strand).all()


def test_files_keep_every_container(tmp_path: Path) -> None:
    curves = fl.Curves.from_bezier(np.random.default_rng(0).random((3, 4, 3)), 0.1, end_attributes={"a": [[0, 1]] * 3})
    geometry = fl.Geometry([*scene().parts, curves])
    for i, one in enumerate([*geometry.parts, geometry]):
        tree = fl.build(one)
        tree.save(tmp_path / f"{i}.flt")
        loaded = fl.load(tmp_path / f"{i}.flt")
        assert type(loaded.geometry) is type(one)
        assert repr(loaded.geometry) == repr(one)
        rays = np.random.default_rng(1).random((200, 3)) * [1, 1, 0] + [0, 0, 5], DOWN
        expected = tree.all_hits(*rays, at="surface")
        assert_same(loaded.all_hits(*rays, at="surface"), expected)
        if "uv" in repr(one):
            np.testing.assert_array_equal(loaded.all_hits(*rays).sample("uv"), tree.all_hits(*rays).sample("uv"))


def test_own_classes_are_not_kept_by_files(tmp_path: Path) -> None:
    tree = fl.build(Balls(np.random.default_rng(0).random((9, 2, 3))))
    with pytest.raises(fl.InputError, match="this one is over UserPrimitives; use pickle"):
        tree.save(tmp_path / "a.flt")
    rays = np.random.default_rng(1).random((50, 3)), [0, 0, 1]
    assert_same(pickle.loads(pickle.dumps(tree)).first_hit(*rays), tree.first_hit(*rays))


def test_a_curve_is_hit_once_for_each_crossing() -> None:
    """Two arches: a ray along them meets each of two legs twice; pieces do not count."""
    control = [[[0, 0, 0], [0, 0, 4], [3, 0, 4], [3, 0, 0]], [[0, 5, 0], [0, 5, 4], [3, 5, 4], [3, 5, 0]]]
    tree = fl.build(fl.Curves.from_bezier(control, radius=0.05))
    assert len(tree.geometry.pieces) > 20  # type: ignore[union-attr]
    along = [[-5, 0, 1], [-5, 5, 1], [-5, 2, 1]], [1, 0, 0]
    hits = tree.all_hits(*along, at="surface")
    assert hits.counts.tolist() == [2, 2, 0]
    assert hits.prim.tolist() == [0, 0, 1, 1]
    assert hits.u[0] < 0.2
    assert hits.u[1] > 0.8
    assert tree.count_hits(*along).tolist() == [2, 2, 0]
    assert tree.next_hits(*along, k=1).prim.tolist() == [0, 1]
    assert tree.all_hits(*along).counts.tolist() == [2, 2, 0]
    first = tree.first_hit(*along, at="surface")
    assert first.prim.tolist() == [0, 1, -1]
    assert (first.u[:2] == hits.u[[0, 2]]).all()
    # The place that the parameter names is where the ray hits, and the tangent is that of the curve.
    points = tree.geometry.evaluate(first.prim[:2], first.u[:2]).points  # type: ignore[union-attr]
    assert np.abs(points - first.points()[:2]).max() < 0.06
    tangents = first.tangents()[:2]
    assert (tangents[:, 2] > 0.9).all()
    np.testing.assert_allclose((first.normals()[:2] ** 2).sum(axis=1), 1)
    # A spread grows the radius with the depth.
    assert tree.count_hits([[-5, 0.5, 1]], [1, 0, 0], spread=0.2).tolist() == [2]


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize("kind", ["lines", "curves", "geometry", "own"])
def test_what_is_ignored_is_as_if_it_were_not_there(kind: str, query: str) -> None:
    rng = np.random.default_rng(6)
    segments = rng.random((60, 1, 3)) + rng.normal(0, 0.2, (60, 2, 3))
    n = 60
    strands = np.arange(n) // 4
    radius = rng.random(n).astype(np.float32) * 0.1

    def make(keep: Any) -> Any:
        if kind == "own":
            balls = Balls(segments)
            balls.centre, balls.own = balls.centre[keep], radius[keep].astype(np.float64)
            return balls
        if kind == "curves":
            control = np.einsum("ij,njk->nik", [[1, 0], [0.6, 0.5], [0.3, 0.6], [0, 1]], segments[keep])
            return fl.Curves.from_bezier(control, radius[keep], strands=strands[keep])
        lines = fl.Lines.from_segments(segments[keep], radius=radius[keep], strands=strands[keep])
        return fl.Geometry([lines]) if kind == "geometry" else lines

    origins = (rng.random((80, 3)) * [1, 1, 0] - [0, 0, 3]).astype(np.float32)
    rays = {"origins": origins, "directions": [0, 0, 1], "radius": 0.05}
    more = {"k": 2} if query == "next_hits" else {}
    dropped = rng.permutation(n)[:25]
    kept = np.setdiff1d(np.arange(n), dropped)
    tree, without = fl.build(make(np.arange(n))), fl.build(make(kept))
    expected = getattr(without, query)(**rays, **more)
    for per_ray in (dropped, np.broadcast_to(dropped, (80, 25))):
        got = getattr(tree, query)(**rays, **more, ignore=per_ray)
        if isinstance(got, np.ndarray):
            assert (got == expected).all()
            continue
        # Frames differ without some lines, so t may differ in the last bits.
        assert np.array_equal(got.prim, np.where(expected.prim >= 0, kept[expected.prim], -1))
        np.testing.assert_allclose(got.t, expected.t, rtol=1e-5)
        assert_same(getattr(tree, query)(**rays, **more, ignore=per_ray, kernel="binary"), got)


def test_rays_ignore_what_they_have_hit() -> None:
    tree = fl.build(scene())
    origins = np.array([[0.5, 0.5, 9], [0.9, 0.5, 9], [9, 9, 9]], np.float32)
    first = tree.first_hit(origins, DOWN)
    second = tree.first_hit(origins, DOWN, ignore=first)
    assert second.part is not None
    assert second.part.tolist() == [1, 0, -1]
    beyond = tree.first_hit(origins, DOWN, ignore=first, ignore_strands=second)
    assert beyond.part is not None
    assert beyond.part.tolist() == [0, 0, -1]
    lines = fl.build(fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 0, -1], [2, 0, -1]]]))
    ray = [[0.5, 0, 5]], DOWN, 0.6
    assert lines.all_hits(*ray).prim.tolist() == [0, 1, 2]
    assert lines.all_hits(*ray, ignore_strands=[0]).prim.tolist() == [2]
    assert lines.all_hits(*ray, ignore=0).prim.tolist() == [1, 2]
    assert lines.any_hit(*ray, ignore=[[0, 1, 2]]).tolist() == [False]
    for wrong, words in (
        (3, "names 3; there are 3 primitives"),
        (lines.all_hits(*ray), "expected first hits"),
        ([[0], [1]], "has shape"),
        ([0.5], "whole numbers"),
    ):
        with pytest.raises(fl.InputError, match=words):
            lines.any_hit(*ray, ignore=wrong)
    both = lines.all_hits([[0.5, 0, 5], [9, 9, 9], [9, 9, 9]], DOWN, 0.6)
    assert len(both) == 3
    with pytest.raises(fl.InputError, match="expected first hits"):
        lines.any_hit([[0.5, 0, 5], [9, 9, 9], [9, 9, 9]], DOWN, 0.6, ignore=both)
    assert lines.first_hit(*ray, ignore=[[]]).prim.tolist() == [0]
    with pytest.raises(fl.InputError, match="ignore_strands names 2; there are 2 strands"):
        lines.any_hit(*ray, ignore_strands=[2])
    larger = fl.build(fl.Lines.from_segments(np.arange(60).reshape(10, 2, 3), radius=np.ones(10)))
    with pytest.raises(fl.InputError, match="ignore_strands names 9; there are 3 primitives"):
        lines.any_hit(*ray, ignore_strands=larger.first_hit([[57, 58, 50]], [0, 0, 1]))
    some = first.prim_number[:2, None]
    again = tree.first_hit(origins[:2], DOWN, ignore=some)
    assert (again.prim_number == second.prim_number[:2]).all()


def test_rows_of_curves_count_what_was_skipped() -> None:
    control = np.zeros((3, 4, 3)) + np.arange(3)[:, None, None] + np.linspace(0, 0.5, 4)[:, None] * [1, 0, 0]
    control[0, 0, 0] = np.nan
    curves = fl.Curves.from_bezier(control, 0.1, invalid="skip")
    hits = fl.build(curves).first_hit([[1.25, 1, 9], [2.25, 2, 9], [9, 9, 9]], DOWN)
    assert hits.prim.tolist() == [0, 1, -1]
    assert hits.row.tolist() == [1, 2, -1]


class Wrong:
    """A class whose parts are given."""

    def __init__(self, bounds: Any, answer: Any) -> None:
        self._bounds, self._answer = bounds, answer

    def bounds(self) -> Any:
        return self._bounds

    def hit(self, ids: Any, rays: Any, radius: Any) -> Any:
        return self._answer(ids)


ONE = np.array([[[0.0, 0, 0], [1, 1, 1]]])


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (Wrong(np.zeros((3, 2)), None), r"Wrong.bounds\(\) has shape \(3, 2\)"),
        (Wrong(ONE * np.nan, None), "1 of 1 boxes of Wrong"),
        (Wrong(ONE[:, ::-1], None), "low corner above their high one"),
        (Wrong(ONE, lambda ids: np.zeros(7)), r"returned 't' of shape \(7,\); expected \(1,\), a row a pair"),
        (Wrong(ONE, lambda ids: {"u": ids}), "returned no 't'"),
        (Wrong(ONE, lambda ids: {"t": ids, "v": ids}), "returned 'v'"),
    ],
)
def test_own_classes_are_told_what_is_wrong(made: Any, words: str) -> None:
    with pytest.raises(fl.InputError, match=words):
        fl.build(made).first_hit([0.5, 0.5, -1], [0, 0, 1])


def test_own_classes_are_clipped_to_smaller_boxes() -> None:
    """A ring of thin tube: the tree is over boxes of its parts, and answers stay the same."""

    class Ring(Balls):
        def __init__(self) -> None:
            angle = np.linspace(0, 2 * np.pi, 400)
            self.points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)

        def bounds(self) -> Any:
            return [[[-1.05, -1.05, -0.05], [1.05, 1.05, 0.05]]]

        def clipped_bounds(self, ids: Any, boxes: Any) -> Any:
            low = np.where(self.inside(boxes)[..., None], self.points - 0.05, np.inf).min(axis=1)
            high = np.where(self.inside(boxes)[..., None], self.points + 0.05, -np.inf).max(axis=1)
            return np.stack([low, high], axis=1)

        def inside(self, boxes: Any) -> Any:
            return ((self.points + 0.07 >= boxes[:, None, 0]) & (self.points - 0.07 <= boxes[:, None, 1])).all(axis=-1)

        def hit(self, ids: Any, rays: Any, radius: Any) -> Any:
            t = -rays.origins[:, 2] / rays.directions[:, 2]
            x = rays.origins + t[:, None] * rays.directions
            return np.where(np.abs(np.hypot(x[:, 0], x[:, 1]) - 1) < 0.05 + radius, t, np.nan)

    ring = Ring()
    tree = fl.build(ring)
    assert tree.n_prims > 4
    rays = np.random.default_rng(2).uniform(-1.2, 1.2, (3000, 3)) * [1, 1, 0] + [0, 0, 2], DOWN
    got = tree.first_hit(*rays)
    assert_same(got, fl.brute_force(ring, *rays, query="first_hit"))
    assert 0.1 < got.hit.mean() < 0.3
    assert tree.all_hits(*rays).counts.max() == 1


def test_clipped_bounds_are_a_box_for_each() -> None:
    class Few(Balls):
        def clipped_bounds(self, ids: Any, boxes: Any) -> Any:
            return boxes[: len(ids) - 1]

    with pytest.raises(fl.InputError, match=r"Few\.clipped_bounds\(\) has shape \(2, 2, 3\); expected \(3, 2, 3\)"):
        fl.build(Few(np.zeros((3, 2, 3))))


def test_geometry_says_what_it_takes() -> None:
    for wrong, words in (
        ([Balls(np.zeros((1, 2, 3)))], "part 0 is a class of your own"),
        ([mesh(), 3], "part 1 is an int"),
        (mesh(), "parts are Triangles"),
    ):
        with pytest.raises(fl.InputError, match=words):
            fl.Geometry(wrong)  # type: ignore[arg-type]
    with pytest.raises(fl.InputError, match="own_radius=False is for lines"):
        fl.build(scene(), own_radius=False)
    with pytest.raises(fl.InputError, match="a spread is for lines"):
        fl.build(scene()).first_hit([0, 0, 9], DOWN, spread=0.1)
    with pytest.raises(fl.InputError, match=r"part 1 \(1 segment\) of this Geometry has no radius of its own"):
        fl.build(fl.Geometry([mesh(), fl.Lines.from_segments([[[0, 0, 0], [1, 1, 1]]])])).first_hit([0, 0, 9], DOWN)
    with pytest.raises(fl.InputError, match="faces name none of the 4 vertices"):
        fl.Triangles.from_mesh(SQUARE, [[0, 1, 4]])
    assert fl.build(fl.Geometry([])).first_hit([0, 0, 9], DOWN).prim == -1
    assert fl.build(fl.Triangles([])).count_hits([0, 0, 9], DOWN) == 0
