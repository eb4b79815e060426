"""Depth of field: a camera with a lens is sharp at one distance, and blurs the rest as a thin lens does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import fastlines as fl
from fastlines.camera import Camera
from fastlines.errors import InputError

LENS = Camera(origin=(1, 2, 3), target=(-1, 0.5, -2), up=(0.2, 1, 0), fov_degrees=40, lens_radius=0.3)
UNIFORM = np.random.default_rng(0).random((2, 63))


@pytest.mark.parametrize("focus", [None, 2.5])
def test_all_rays_of_a_pixel_meet_in_the_plane_of_focus(focus):
    camera = Camera(LENS.origin, LENS.target, LENS.up, 40, 0.3, focus)
    _, pinhole = camera.rays(9, 7)
    origins, directions = camera.through_lens(pinhole, *UNIFORM)
    assert origins.dtype == directions.dtype == np.float32
    assert np.allclose(np.linalg.norm(directions, axis=1), 1, atol=1e-6)
    right, up, forward = camera.axes()
    distance = np.linalg.norm(np.subtract(camera.target, camera.origin)) if focus is None else focus
    assert camera.focus == pytest.approx(distance)
    expected = camera.origin + pinhole * (distance / (pinhole @ forward))[:, None]
    given = origins + directions * ((distance - (origins - camera.origin) @ forward) / (directions @ forward))[:, None]
    assert np.allclose(given, expected, atol=2e-6)
    # Points of the lens are in its plane, evenly distributed over its disc.
    on_lens = origins - camera.origin
    assert np.allclose(on_lens @ forward, 0, atol=1e-6)
    away = np.hypot(on_lens @ right, on_lens @ up)
    assert np.allclose(away, 0.3 * np.sqrt(UNIFORM[0]), atol=1e-6)


def width_at(distance, **lens):
    """Return how wide a thin upright line at a distance is in the picture: the standard deviation, in pixels."""
    camera = Camera(origin=(0, 0, 0), target=(0, 0, -4), fov_degrees=2, **lens)
    line = [[[0, -9, -distance], [0, 9, -distance]]]
    picture = fl.render(line, camera, width=129, height=3, look="id", radius=0.001, samples=256)
    across = picture.alpha.mean(axis=0)
    place = np.arange(129) - 64
    return float(np.sqrt((across * place**2).sum() / across.sum()))


@pytest.mark.slow
def test_a_line_is_blurred_by_the_circle_of_confusion():
    sharp, blurred = width_at(4, lens_radius=0.2), width_at(2, lens_radius=0.2)
    assert max(sharp, width_at(2, lens_radius=0.2, focus_distance=2.0)) < 0.6
    # In the plane of focus, at 4, the circle of a point at 2 is as large as the lens. The deviation of a disc is half
    # its radius.
    pixel = 2 * 4 * np.tan(np.radians(1)) / 3
    assert np.sqrt(blurred**2 - sharp**2) == pytest.approx(0.2 / 2 / pixel, rel=0.05)


def test_a_lens_keeps_the_light_and_takes_more_samples():
    lines = fl.scenes.make("spaghetti", 200).lines
    plain = Camera.framing(lines, (0, 1, 0), up=(0, 0, 1))
    lens = replace(plain, lens_radius=0.01)
    pictures = [fl.render(lines, camera, width=48, height=48, radius=0.001) for camera in (plain, lens)]
    assert [picture.samples for picture in pictures] == [4, 64]
    for what in ("alpha", "light"):
        plain, blurred = (getattr(picture, what).mean() for picture in pictures)
        assert blurred == pytest.approx(plain, rel=0.05)


@pytest.mark.parametrize("shape", [(), (63,), (9, 7)])
def test_rays_have_any_shape(shape):
    u, v = (values.flat[: int(np.prod(shape))].reshape(shape) for values in UNIFORM)
    pinhole = np.broadcast_to(LENS.ray(3, 4, 9, 7)[1], (*shape, 3))
    origins, directions = LENS.through_lens(pinhole, u, v)
    assert origins.shape == directions.shape == (*shape, 3)
    one = LENS.through_lens(pinhole.reshape(-1, 3)[:1], u.ravel()[:1], v.ravel()[:1])
    assert (origins.reshape(-1, 3)[:1] == one[0]).all()
    assert (directions.reshape(-1, 3)[:1] == one[1]).all()


@pytest.mark.parametrize(
    ("rays", "said"),
    [
        (([[0, 0, 1]], [0.5], [0.5]), "do not point forward"),
        (([[np.nan, 0, -1]], [0.5], [0.5]), "do not point forward"),
        (([[0, 0, -1]], [2.0], [0.5]), "not from 0 to 1"),
        (([[0, 0, -1]], [0.5], [np.nan]), "not from 0 to 1"),
        (([[0, 0, -1]], 0.5, 0.5), "have shapes (1, 3), () and (); expected"),
        (([[0, 0]], [0.5], [0.5]), "have shapes (1, 2), (1,) and (1,); expected"),
        ((["a"], [0.5], [0.5]), "cannot be read as arrays of numbers"),
    ],
)
def test_rays_that_no_lens_has_are_refused(rays, said):
    with pytest.raises(InputError) as caught:
        Camera((0, 0, 4), (0, 0, 0), lens_radius=0.1).through_lens(*rays)
    assert said in str(caught.value)


def test_a_turn_keeps_the_lens():
    turned = LENS.orbit(30)
    assert (turned.lens_radius, turned.focus_distance) == (0.3, None)
    assert turned.focus == pytest.approx(LENS.focus)


@pytest.mark.parametrize(
    ("lens", "said"),
    [
        ({"lens_radius": -1}, "lens_radius=-1; expected a radius: a finite number that is not negative"),
        ({"lens_radius": np.nan}, "lens_radius=nan; expected a radius"),
        ({"lens_radius": "wide"}, "lens_radius='wide'; expected a radius"),
        ({"focus_distance": 0}, "focus_distance=0; expected a distance: a finite number above 0"),
        ({"focus_distance": np.inf}, "focus_distance=inf; expected a distance"),
    ],
)
def test_bad_lenses_are_refused(lens, said):
    with pytest.raises(InputError) as caught:
        Camera((0, 0, 4), (0, 0, 0), **lens)
    assert said in str(caught.value)


@pytest.mark.parametrize("look", ["hits", "density", "work"])
def test_numbers_of_rays_have_no_lens(look):
    with pytest.raises(InputError, match=r"lens_radius=0.3 does not apply: the look .* counts along rays from a pinh"):
        fl.render([[[0, 0, 0], [1, 0, 0]]], LENS, width=8, height=8, look=look)
