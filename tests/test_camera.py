"""The camera: rays and projection agree, and a frame holds all that it should, tightly."""

import numpy as np
import pytest

import fastlines as fl
from fastlines.camera import Camera
from fastlines.errors import InputError
from fastlines.geometry.lines import Lines

CAMERA = Camera(origin=(1, 2, 3), target=(-1, 0.5, -2), up=(0.2, 1, 0), fov_degrees=40)


def margins(camera, points, width, height):
    """What is free at the left, right, top and bottom, as shares of the picture."""
    pixels, depth = camera.project(points, width, height)
    assert (depth > 0).all()
    share = pixels / (width, height)
    return np.concatenate([share.min(axis=0), 1 - share.max(axis=0)])


def test_rays_go_through_the_pixel_centres():
    width, height = 7, 4
    origins, directions = CAMERA.rays(width, height)
    assert origins.dtype == directions.dtype == np.float32
    assert origins.shape == directions.shape == (28, 3)
    assert (origins == np.float32([1, 2, 3])).all()
    assert np.allclose(np.linalg.norm(directions, axis=1), 1, atol=1e-6)

    pixels, depth = CAMERA.project(origins + 5.0 * directions, width, height)
    row, column = np.divmod(np.arange(28), width)
    assert np.allclose(pixels, np.stack([column + 0.5, row + 0.5], axis=1), atol=1e-4)
    assert ((depth > 0) & (depth <= 5.0001)).all()


def test_field_of_view_is_vertical():
    camera = Camera(origin=(0, 0, 0), target=(0, 0, -1), fov_degrees=90)
    pixels, depth = camera.project([[0, 1, -1], [2, -1, -1], [0, 0, -5]], 200, 100)
    assert np.allclose(pixels, [[100, 0], [200, 100], [100, 50]])
    assert np.allclose(depth, [1, 1, 5])


def test_points_behind_have_no_pixel():
    camera = Camera(origin=(0, 0, 0), target=(0, 0, -1))
    pixels, depth = camera.project([[0, 0, 1], [1, 0, 0], [0, 0, -1]], 10, 10)
    assert np.isnan(pixels[:2]).all()
    assert pixels[2].tolist() == [5, 5]
    assert depth.tolist() == [-1, 0, 1]


@pytest.mark.parametrize("aspect", [0.3, 1.0, 2.5])
@pytest.mark.parametrize(("scale", "offset"), [(1, 0), (1e-8, 0), (1e8, 0), (1, 1e4), (1e-3, 1e3), (1e30, 0)])
def test_framing_is_tight(aspect, scale, offset):
    points = np.random.default_rng(1).random((500, 3)) * scale + offset
    camera = Camera.framing(points, (1, -2, -3), fov_degrees=35, aspect=aspect)
    free = margins(camera, points, round(600 * aspect), 600)
    # Two opposite sides touch the frame less its margin; the other two keep at least that, equally.
    assert np.allclose(free.min(), 0.025, atol=1e-5)
    assert (free > 0.025 - 1e-5).all()
    assert min(abs(free[0] - free[2]), abs(free[1] - free[3])) < 1e-5
    forward = camera.axes()[2]
    assert np.allclose(forward, np.array([1, -2, -3]) / np.sqrt(14), atol=1e-6)


@pytest.mark.parametrize("fov", [1, 30, 110, 170])
def test_framing_at_any_field_of_view(fov):
    points = np.random.default_rng(2).normal(size=(100, 3))
    camera = Camera.framing(points, fov_degrees=fov, margin=0)
    free = margins(camera, points, 64, 64).min()
    # The widest view would be touched by its nearest point alone: the camera keeps away from that.
    assert free > 0.1 if fov == 170 else abs(free) < 1e-9


@pytest.mark.parametrize(
    "points",
    [
        [[3, 4, 5]],
        [[1e8, 0, 0]],
        [[0, 0, 0], [1, 0, 0]],
        [[0, 0, 0], [0, 0, 9]],  # along the view
        [[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]],  # a plane seen edge on
        [[5, 5, 5]] * 3,
        [[1e6, 1e6, 1e6], [1e6 + 1e-9, 1e6, 1e6]],
    ],
)
def test_framing_flat_geometry(points):
    camera = Camera.framing(points, direction=(0, 0, -1))
    assert margins(camera, points, 100, 100).min() > 0.02


def test_framing_nothing():
    for nothing in ([], np.empty((0, 2, 3)), Lines.from_segments([]), Lines.from_segments([]).bounds):
        camera = Camera.framing(nothing)
        assert np.allclose(camera.project([[0, 0, 0]], 10, 10)[0], [[5, 5]])


def test_framing_a_box_shows_its_corners():
    camera = Camera.framing([[0, 0, 0], [1, 2, 3]], direction=(1, 1, 1))
    corners = np.stack(np.meshgrid([0, 1], [0, 2], [0, 3]), axis=-1).reshape(-1, 3)
    assert np.allclose(margins(camera, corners, 50, 50).min(), 0.025)


def test_framing_lines_shows_their_ends():
    segments = np.random.default_rng(3).random((40, 2, 3), np.float32)
    expected = Camera.framing(segments.reshape(-1, 3))
    assert Camera.framing(Lines.from_segments(segments)) == Camera.framing(segments) == expected


def test_direction_parallel_to_up():
    points = np.random.default_rng(4).random((50, 3))
    for direction in ((0, -1, 0), (0, 1, 0), (1e-9, 1, 0), (0, 1e-200, 0)):
        camera = Camera.framing(points, direction)
        assert np.allclose(camera.axes() @ camera.axes().T, np.eye(3))
        assert np.allclose(margins(camera, points, 30, 30).min(), 0.025)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"origin": (0, 0)}, "three numbers"),
        ({"target": "here"}, "three numbers"),
        ({"target": (0, np.nan, 0)}, "finite"),
        ({"target": (1, 2, 3)}, "move one"),
        ({"up": (0, 0, 0)}, "up is zero"),
        ({"fov_degrees": 180}, "between 0 and 180"),
        ({"fov_degrees": np.nan}, "between 0 and 180"),
    ],
)
def test_cameras_that_can_not_be(change, message):
    with pytest.raises(InputError, match=message):
        Camera(**{"origin": (1, 2, 3), "target": (0, 0, 0), **change})


@pytest.mark.parametrize("size", [0, -3, 1.5, True, "8", None])
def test_sizes_that_can_not_be(size):
    with pytest.raises(InputError, match="width"):
        CAMERA.rays(size, 4)
    with pytest.raises(InputError, match="height"):
        CAMERA.project([[0, 0, 0]], 4, size)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"direction": (0, 0, 0)}, "direction is zero"),
        ({"aspect": 0}, "aspect"),
        ({"margin": 0.5}, "margin"),
        ({"fov_degrees": 0}, "between 0 and 180"),
        ({"up": (0, 0, 0)}, "up is zero"),
        ({"geometry": [[1, 2]]}, "expected \\(m, 3\\)"),
        ({"geometry": [[1, 2, np.inf]]}, "finite"),
        ({"geometry": [[0, 0, 0], [1, np.inf, 1]]}, "finite"),
        ({"geometry": "hair"}, "numbers"),
    ],
)
def test_frames_that_can_not_be(arguments, message):
    with pytest.raises(InputError, match=message):
        Camera.framing(**{"geometry": [[0, 0, 0], [1, 1, 1]], **arguments})


def test_framing_shows_the_thickness_of_lines() -> None:
    rng = np.random.default_rng(4)
    spheres = fl.Spheres.from_centres(rng.normal(size=(50, 3)), rng.uniform(0.1, 1, 50))
    camera = Camera.framing(spheres)
    tree = fl.build(spheres)
    size = 200
    seen = tree.any_hit(*camera.rays(size, size)).reshape(size, size)
    border = np.concatenate([seen[0], seen[-1], seen[:, 0], seen[:, -1]])
    assert not border.any()
    # Without their radii, spheres are cut off.
    assert tree.any_hit(*Camera.framing(spheres.centres).rays(size, size)).reshape(size, size)[[0, -1]].any()


def test_the_ray_of_a_pixel_is_that_of_the_picture() -> None:
    camera = fl.Camera(origin=(1, 2, 3), target=(-1, 0.5, 0), fov_degrees=50)
    origins, directions = camera.rays(7, 5)
    y, x = np.mgrid[:5, :7]
    origin, direction, spread = camera.ray(x.ravel() + 0.5, y.ravel() + 0.5, 7, 5)
    assert np.array_equal(origin, origins)
    assert np.array_equal(direction, directions)
    one = camera.ray(2.5, 1.5, 7, 5)
    assert np.array_equal(one[1], directions[1 * 7 + 2])
    assert one[0].dtype == one[1].dtype == np.float32
    assert one[2] == spread == camera.spread(5) == pytest.approx(np.tan(np.radians(25)) / 5)


def test_the_ray_through_a_point_of_the_picture_passes_what_is_seen_there() -> None:
    camera = fl.Camera(origin=(1, 2, 3), target=(-1, 0.5, 0), fov_degrees=50)
    points = np.random.default_rng(0).uniform(-1, 1, (50, 3))
    pixels, _ = camera.project(points, 640, 480)
    origin, direction, _ = camera.ray(*pixels.T, 640, 480)
    away = np.cross(points - origin, direction)
    assert np.linalg.norm(away, axis=1).max() < 1e-6


def test_a_spread_is_half_a_pixel_in_the_middle_and_little_more_at_the_side() -> None:
    camera = fl.Camera(origin=(0, 0, 0), target=(0, 0, -1), fov_degrees=90)
    for x, y in ((50, 50), (50, 0), (0, 0)):
        _, direction, spread = camera.ray(x, y, 100, 100)
        _, beside, _ = camera.ray(x + 0.5, y, 100, 100)
        half_pixel = np.tan(np.arccos(np.dot(direction.astype(float), beside) / 1.0))
        cosine = -direction[2]
        assert 0.99 * spread * cosine**2 < half_pixel < 1.01 * spread * cosine


@pytest.mark.parametrize(("x", "y"), [(np.nan, 0), (0, np.inf), ("left", 0), ([1, 2], [1, 2, 3])])
def test_points_of_no_picture_have_no_ray(x, y) -> None:
    with pytest.raises(fl.InputError, match="x and y"):
        fl.Camera(origin=(0, 0, 0), target=(0, 0, -1)).ray(x, y, 100, 100)
