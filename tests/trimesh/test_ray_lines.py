"""`RayLines` beside trimesh's own ray queries, and as users of trimesh would call it."""

from __future__ import annotations

import inspect
import pickle
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines.errors import FileWarning, InputError
from fastlines.trimesh import RayLines

#: Three wires along x; the second has two segments.
WIRES = [[[0, 0, 0], [4, 0, 0]], [[0, 0, 2], [2, 0, 2], [4, 0, 2]], [[0, 3, 1], [4, 3, 1]]]
DOWN = np.array([[1, 0.05, 9], [3, -0.1, 9], [1, 2.9, 9], [8, 8, 9]])


@pytest.fixture
def path() -> Any:
    trimesh = pytest.importorskip("trimesh")
    entities = [trimesh.path.entities.Line(points) for points in ([0, 1], [2, 3, 4], [5, 6])]
    return trimesh.path.Path3D(entities, np.concatenate(WIRES), process=False)


@pytest.mark.parametrize("name", ["intersects_location", "intersects_id", "intersects_first", "intersects_any"])
def test_arguments_are_those_of_trimesh(name: str) -> None:
    pytest.importorskip("embreex")
    theirs = pytest.importorskip("trimesh.ray.ray_pyembree").RayMeshIntersector
    given = getattr(theirs, name)
    if given.__closure__:  # of a decorator that hides the arguments
        given = given.__closure__[0].cell_contents
    names, ours = (list(inspect.signature(method).parameters) for method in (given, getattr(RayLines, name)))
    assert ours == [*names, "radius", "options"]


def test_a_path(path: Any) -> None:
    rays = RayLines(path, radius=0.2)
    locations, index_ray, index_line = rays.intersects_location(DOWN, [[0, 0, -1]] * 4)
    np.testing.assert_array_equal(index_ray, [0, 0, 1, 1, 2])
    np.testing.assert_array_equal(index_line, [1, 0, 2, 0, 3])
    np.testing.assert_array_equal(rays.index_entity[index_line], [1, 0, 1, 0, 2])
    height = np.sqrt(0.04 - np.array([0.05, 0.05, 0.1, 0.1, 0.1]) ** 2)
    expected = np.column_stack([DOWN[index_ray, :2], np.array([2, 0, 2, 0, 1]) + height])
    np.testing.assert_allclose(locations, expected, atol=1e-6)
    assert (locations.dtype, index_ray.dtype, index_line.dtype) == (np.float64, np.int64, np.int64)
    np.testing.assert_array_equal(rays.intersects_first(DOWN, [[0, 0, -1]] * 4), [1, 2, 3, -1])
    np.testing.assert_array_equal(rays.intersects_any(DOWN, [[0, 0, -1]] * 4), [True, True, True, False])
    first, rows = rays.intersects_id(DOWN, [[0, 0, -1]] * 4, multiple_hits=False)
    np.testing.assert_array_equal(first, [1, 2, 3])
    np.testing.assert_array_equal(rows, [0, 1, 2])
    for most in (1, 2, 9):
        some = rays.intersects_id(DOWN, [[0, 0, -1]] * 4, True, most)[0]
        np.testing.assert_array_equal(some, [1, 2, 3] if most == 1 else index_line)
    with_points = rays.intersects_id(DOWN, [[0, 0, -1]] * 4, return_locations=True)
    np.testing.assert_array_equal(with_points[2], locations)


def test_hits_are_those_of_a_mesh_of_tubes() -> None:
    """trimesh hits a mesh of cylinders where `RayLines` hits the lines."""
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("rtree")
    tubes = [trimesh.creation.cylinder(0.2, segment=ends, sections=256) for ends in (WIRES[0], WIRES[2])]
    mesh = trimesh.ray.ray_triangle.RayMeshIntersector(trimesh.util.concatenate(tubes))
    given = DOWN, np.array([[0, 0, -1.0]] * 3 + [[1, 0, 0]])
    lines = RayLines([WIRES[0], WIRES[2]], radius=0.2)
    expected, rows, _ = mesh.intersects_location(*given, multiple_hits=False)
    locations, index_ray, index_line = lines.intersects_location(*given, multiple_hits=False)
    np.testing.assert_array_equal(index_ray, np.sort(rows))
    np.testing.assert_allclose(locations, expected[np.argsort(rows)], atol=1e-4)
    np.testing.assert_array_equal(index_line, [0, 0, 1])
    np.testing.assert_array_equal(lines.intersects_any(*given), mesh.intersects_any(*given))


def test_the_radius(path: Any) -> None:
    rays = RayLines(path)
    with pytest.raises(InputError, match="these lines have no radius of their own, so a query needs one"):
        rays.intersects_any(DOWN, [[0, 0, -1]])
    np.testing.assert_array_equal(rays.intersects_first(DOWN, [[0, 0, -1]], radius=0.07), [1, -1, -1, -1])
    each = np.array([0.2, 0.2, 0.05, 9])
    np.testing.assert_array_equal(RayLines(path, each).intersects_any(DOWN, [[0, 0, -1]]), [True, True, False, True])
    thick = RayLines(fl.lines(path).with_radius(0.2))
    np.testing.assert_array_equal(thick.intersects_first(DOWN, [[0, 0, -1]]), [1, 2, 3, -1])
    assert RayLines(path, 0.1).intersects_first(DOWN, [[0, 0, -1]], radius=0.2)[1] == 2


def test_options_of_queries(path: Any) -> None:
    rays = RayLines(path, 0.2)
    nearest, _, _ = rays.intersects_location(DOWN[:1], [[0, 0, -1]], at="closest")
    np.testing.assert_allclose(nearest, [[1, 0.05, 2], [1, 0.05, 0]], atol=1e-6)
    assert rays.intersects_first(DOWN[:1], [[0, 0, -1]], ignore=[1]) == [0]
    assert not rays.intersects_any(DOWN[:1], [[0, 0, -1]], t_max=3)
    assert rays.intersects_first([[np.nan, 0, 0]], [[0, 0, -1]], invalid="skip") == [-1]
    inside, _, _ = rays.intersects_location([[1, 0, 0]], [[0, 0, -1]])
    np.testing.assert_array_equal(inside, [[1, 0, 0]])


def test_a_path_that_changes(path: Any) -> None:
    rays = RayLines(path, 0.2)
    before = rays.tree
    assert rays.tree is before
    path.vertices[:2] += [0, 0, 5]
    assert rays.intersects_first(DOWN[:1], [[0, 0, -1]]) == [0]
    assert rays.tree is not before
    path.apply_translation([0, 100, 0])
    assert not rays.intersects_any(DOWN, [[0, 0, -1]]).any()
    path.entities = path.entities[:1]
    assert (len(rays.lines), rays.index_entity.tolist()) == (1, [0])


def test_other_lines(path: Any) -> None:
    tree = fl.build(fl.lines(path), "kd-d2")
    rays = RayLines(tree, 0.2)
    assert rays.tree is tree
    np.testing.assert_array_equal(rays.intersects_first(DOWN, [[0, 0, -1]]), [1, 2, 3, -1])
    curves = fl.Curves.from_bezier([[[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]], radius=0.2)
    assert RayLines(curves).intersects_first(DOWN[:1], [[0, 0, -1]]) == [0]
    assert RayLines(WIRES, 0.2).index_entity.tolist() == [0, 1, 1, 2]
    assert RayLines(np.array(WIRES[::2]), 0.2).index_entity.tolist() == [-1, -1]
    assert len(RayLines([], 0.2).intersects_id(DOWN, [[0, 0, -1]])[0]) == 0
    assert repr(rays) == "<RayLines: <Lines: 4 segments, 3 strands>>"
    again = pickle.loads(pickle.dumps(rays))
    np.testing.assert_array_equal(again.intersects_first(DOWN, [[0, 0, -1]]), [1, 2, 3, -1])


def test_a_section_of_a_mesh_and_a_path_in_the_plane() -> None:
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("networkx")
    section = trimesh.creation.icosphere().section([0, 0, 1], [0, 0, 0])
    rays = RayLines(section, 0.01)
    locations, _, _ = rays.intersects_location([[5, 0, 0.001]], [[-1, 0, 0]])
    assert len(locations) >= 2
    np.testing.assert_allclose(np.abs(locations[:, 0]), 1, atol=0.02)
    flat, _ = section.to_2D()
    with pytest.warns(FileWarning, match="the points have two coordinates"):
        assert RayLines(flat, 0.01).intersects_any([[0, 0, 1]], [[0, 0, -1]]).tolist() == [False]


def test_no_rays() -> None:
    rays = RayLines(WIRES, 0.2)
    for none in ([], np.empty((0, 3))):
        assert [len(found) for found in rays.intersects_location(none, none)] == [0, 0, 0]
        assert rays.intersects_location(none, none)[0].shape == (0, 3)
        assert rays.intersects_first(none, none).shape == rays.intersects_any(none, none).shape == (0,)


@pytest.mark.parametrize(
    ("origins", "directions", "more", "said"),
    [
        (
            [1, 2, 3],
            [0, 0, 1],
            {},
            r"ray_origins have shape \(3,\); expected \(n, 3\), .*: a single ray is \[\[x, y, z",
        ),
        ([[1, 2]], [[0, 1]], {}, r"ray_origins have shape \(1, 2\); expected \(n, 3\), x y z of each ray"),
        (np.zeros((2, 4, 3)), np.ones((2, 4, 3)), {}, r"shape \(2, 4, 3\); expected .*reshape\(-1, 3\)"),
        (DOWN, [[0, 0, 1]] * 3, {}, r"origins \(4, 3\) and directions \(3, 3\) do not match"),
        (DOWN, np.zeros((4, 3)), {}, "4 of 4 rays have a direction of length zero"),
        (DOWN * np.nan, [[0, 0, 1]], {}, r"4 of 4 rays have an origin that is not finite"),
        (DOWN, [[0, 0, 1]], {"max_hits": 2.5}, "max_hits=2.5; expected a whole number, 0 or more"),
        (DOWN, [[0, 0, 1]], {"radius": -1}, "have a radius that is not a number from 0"),
        (DOWN, [[0, 0, 1]], {"at": "middle"}, "at='middle'"),
        (["a"], [[0, 0, 1]], {}, "ray_origins"),
    ],
)
def test_rays_that_are_refused(origins: Any, directions: Any, more: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        RayLines(WIRES, 0.2).intersects_id(origins, directions, **more)


def test_what_is_no_line() -> None:
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box()
    with pytest.raises(
        InputError, match=r"lines are a Trimesh, a surface of triangles; trimesh queries it itself, by m"
    ):
        RayLines(box)
    with pytest.raises(InputError, match=r"lines are a Scene of trimesh; expected a path: scene\.to_geometry"):
        RayLines(trimesh.Scene([box]))
    with pytest.raises(InputError, match="lines are a tree over Triangles; expected one over lines or curves"):
        RayLines(fl.Triangles(box.triangles))
    with pytest.raises(InputError, match="lines are a tree over Spheres; expected one over lines or curves"):
        RayLines(fl.Spheres.from_centres([[0, 0, 0]], 1))


def test_no_hit_is_listed_where_none_is_wanted(path: Any) -> None:
    rays = RayLines(path, 0.5)
    for multiple_hits in (True, False):
        assert len(rays.intersects_id(DOWN, [[0, 0, -1]], multiple_hits, max_hits=0)[0]) == 0


def test_a_radius_is_given_by_its_name(path: Any) -> None:
    """By position it would be `multiple_hits`, as in trimesh."""
    rays = RayLines(path, 0.5)
    for method in (rays.intersects_location, rays.intersects_id):
        with pytest.raises(
            InputError, match=r"multiple_hits=0\.1; expected True or False; a radius is given as radius="
        ):
            method(DOWN, [[0, 0, -1]], 0.1)
    with pytest.raises(InputError, match="return_locations=1; expected True or False"):
        rays.intersects_id(DOWN, [[0, 0, -1]], True, None, 1)
    assert len(rays.intersects_id(DOWN, [[0, 0, -1]], np.False_)[0]) == 3


@pytest.mark.parametrize("radius", [-0.1, "a", np.nan, np.inf, [0.1, -1], [[0.1]]])
def test_a_radius_that_is_refused(radius: Any) -> None:
    with pytest.raises(InputError, match="radius"):
        RayLines(WIRES, radius)


def test_options_that_are_not_there() -> None:
    rays = RayLines(WIRES, 0.2)
    with pytest.raises(TypeError, match=r"intersects_first has no option 'tmax' here; did you mean 't_max'"):
        rays.intersects_first(DOWN, [[0, 0, -1]], tmax=1)
    with pytest.raises(TypeError, match="intersects_any has no option 'merge' here; known: "):
        rays.intersects_any(DOWN, [[0, 0, -1]], merge="strand")
    for more in ({"max_hits": 2}, {"multiple_hits": False}):
        with pytest.raises(TypeError, match="intersects_id has no option 'merge' here; known: "):
            rays.intersects_id(DOWN, [[0, 0, -1]], merge="strand", **more)
    joint = [[2, 0, 9]]
    assert rays.intersects_id(joint, [[0, 0, -1]])[0].tolist() == [1, 2, 0]
    assert rays.intersects_id(joint, [[0, 0, -1]], merge="strand")[0].tolist() == [1, 0]


def test_a_path_far_from_zero_that_changes(path: Any) -> None:
    far = np.array([1e8, -2e8, 5e7])
    path.vertices = path.vertices + far
    rays = RayLines(path, 0.2, offset="auto")
    origins = DOWN + far
    locations, index_ray, index_line = rays.intersects_location(origins, [[0, 0, -1]] * 4)
    np.testing.assert_array_equal(index_line, [1, 0, 2, 0, 3])
    np.testing.assert_allclose(locations[:, :2], origins[index_ray, :2], atol=1e-6)
    height = np.sqrt(0.04 - np.array([0.05, 0.05, 0.1, 0.1, 0.1]) ** 2)
    np.testing.assert_allclose(locations[:, 2] - far[2], np.array([2, 0, 2, 0, 1]) + height, atol=1e-5)
    path.apply_translation([0, 0.3, 0])
    assert rays.intersects_first(origins, [[0, 0, -1]]).tolist() == [-1, -1, -1, -1]
    assert rays.intersects_first(origins + np.array([0, 0.3, 0]), [[0, 0, -1]]).tolist() == [1, 2, 3, -1]


def test_how_lines_are_read(path: Any) -> None:
    entities = pytest.importorskip("trimesh.path.entities")
    path.entities = [entities.Arc([0, 2, 4])]
    counts = [len(RayLines(path, 0.1, tolerance=tolerance).lines) for tolerance in (0.1, None, 1e-6)]
    assert counts[0] < counts[1] < counts[2]
    broken = np.array([[[0, 0, 0], [1, 0, 0]], [[np.nan, 0, 0], [1, 0, 0]]])
    assert len(RayLines(broken, 0.1, invalid="skip").lines) == 1
    curves = fl.Curves.from_bezier([[[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]], radius=0.2)
    for made in (fl.build(WIRES), curves):
        with pytest.raises(InputError, match="offset= is for lines that are read here, and lines are "):
            RayLines(made, offset=np.zeros(3))


@pytest.mark.parametrize("radius", [50, 1000])
def test_rays_through_an_arc(radius: float) -> None:
    """All rays through the arc itself are within 0.1 of its polyline."""
    made = pytest.importorskip("trimesh.path")
    entities = pytest.importorskip("trimesh.path.entities")
    ends = np.array([[radius, 0, 0], [0, radius, 0], [-radius, 0, 0]])
    rays = RayLines(made.Path3D([entities.Arc([0, 1, 2])], ends, process=False), 0.1)
    angles = np.random.default_rng(0).random(500) * np.pi
    through = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(500, 9.0)])
    assert rays.intersects_any(through, [[0, 0, -1]]).all()
