"""Scattering by a fibre: energy, densities, samples, symmetries, extreme angles, and values of Mitsuba."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from fastlines.errors import InputError
from fastlines.rendering.hair import HairMaterial, evaluate, evaluate_angles, pdf, sample
from fastlines.rendering.hair.longitudinal import longitudinal, scaled_i0

CLEAR = (0.0, 0.0, 0.0)
ROUGHNESS = [(0.3, 0.3), (0.1, 0.2), (0.6, 0.9), (1.0, 1.0)]
#: Made by: fastlines-bench hair --examples tests/rendering/mitsuba_hair.json
MITSUBA = json.loads((Path(__file__).parent / "mitsuba_hair.json").read_text(encoding="utf-8"))["examples"]


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def random_rays(n, seed=0):
    """Return wo, wi, tangents and offsets."""
    rng = np.random.default_rng(seed)
    return *(unit(rng.normal(size=(n, 3))) for _ in range(3)), rng.uniform(-1, 1, n)


def sphere(n_sine=400, n_phi=100):
    """Return sines, azimuths and the solid angle of each cell of the sphere."""
    sine = (np.arange(n_sine) + 0.5) * (2 / n_sine) - 1
    phi = (np.arange(n_phi) + 0.5) * (2 * np.pi / n_phi)
    return *(each.ravel() for each in np.meshgrid(sine, phi)), 4 * np.pi / (n_sine * n_phi)


# --- Energy ---


@pytest.mark.parametrize(("longitudinal_roughness", "azimuthal_roughness"), ROUGHNESS)
@pytest.mark.parametrize("sin_o", [0.0, 0.5, -0.97])
def test_white_furnace(longitudinal_roughness, azimuthal_roughness, sin_o):
    material = HairMaterial(CLEAR, longitudinal_roughness, azimuthal_roughness, scale_tilt=4)
    sine, phi, cell = sphere()
    for h in (-0.9, 0.2, 0.6):
        value = evaluate_angles(material, sin_o, sine, phi, h)
        assert value.sum(axis=0) * cell == pytest.approx([1, 1, 1], abs=0.003)


def test_absorption_loses_energy():
    sine, phi, cell = sphere()
    albedo = [evaluate_angles(HairMaterial((s, s, s)), 0.2, sine, phi, 0.3).sum(axis=0)[0] * cell for s in (0, 0.3, 3)]
    assert albedo[0] > albedo[1] > albedo[2] > 0.01


def test_samples_without_absorption_weigh_one():
    for roughness in ROUGHNESS:
        wo, _, tangent, h = random_rays(2000)
        u4 = np.random.default_rng(1).random((2000, 4))
        wi, weight, density = sample(HairMaterial(CLEAR, *roughness), wo, tangent, h, u4)
        assert weight == pytest.approx(1, abs=1e-9)
        assert np.linalg.norm(wi, axis=1) == pytest.approx(1, abs=1e-12)
        assert (density > 0).all()


def test_mean_weight_is_the_albedo():
    material = HairMaterial((0.1, 0.6, 2.0), scale_tilt=3)
    sine, phi, cell = sphere()
    n = 60_000
    for sin_o, h in ((0.0, 0.1), (0.7, -0.6)):
        albedo = evaluate_angles(material, sin_o, sine, phi, h).sum(axis=0) * cell
        wo = (sin_o, 0, math.sqrt(1 - sin_o**2))
        _, weight, _ = sample(material, wo, (1, 0, 0), h, np.random.default_rng(0).random((n, 4)))
        assert weight.mean(axis=0) == pytest.approx(albedo, rel=0.02)
        assert weight.max() < 1 / 0.07  # one over the luminance of blue


# --- Densities and samples ---


@pytest.mark.parametrize(("longitudinal_roughness", "azimuthal_roughness"), ROUGHNESS)
def test_density_integrates_to_one_and_is_that_of_the_samples(longitudinal_roughness, azimuthal_roughness):
    material = HairMaterial((0.2, 0.5, 1.5), longitudinal_roughness, azimuthal_roughness)
    sine, phi, cell = sphere()
    cosine = np.sqrt(1 - sine**2)
    wi = np.stack([sine, cosine * np.cos(phi), cosine * np.sin(phi)], axis=1)
    wo, tangent, h = unit(np.array([0.4, 1.0, 0.3])), (1, 0, 0), 0.45
    density = pdf(material, wo, wi, tangent, h) * cell
    assert density.sum() == pytest.approx(1, abs=0.003)
    # Compare means of smooth functions of the direction.
    drawn, _, _ = sample(material, wo, tangent, h, np.random.default_rng(2).random((60_000, 4)))
    for function in (
        lambda w: w[:, 0],
        lambda w: w[:, 1],
        lambda w: w[:, 2],
        lambda w: w[:, 0] ** 2,
        lambda w: w[:, 1] ** 3,
    ):
        assert function(drawn).mean() == pytest.approx((function(wi) * density).sum(), abs=0.01)


def test_sample_returns_what_pdf_and_evaluate_do():
    material = HairMaterial.from_melanin(0.4, scale_tilt=5)
    wo, _, tangent, h = random_rays(1000, 3)
    wi, weight, density = sample(material, wo, tangent, h, np.random.default_rng(4).random((1000, 4)))
    assert density == pytest.approx(pdf(material, wo, wi, tangent, h), rel=1e-9)
    assert weight * density[:, None] == pytest.approx(evaluate(material, wo, wi, tangent, h), rel=1e-9)


def test_uniform_numbers_at_their_bounds():
    corners = np.array(np.meshgrid(*[[0.0, 0.5, 1.0]] * 4)).reshape(4, -1).T
    for roughness in (0.001, 0.3, 1.0):
        for kind in (np.float32, np.float64):
            wo, tangent = np.array([0.6, 0.8, 0], kind), np.array([1, 0, 0], kind)
            material = HairMaterial(longitudinal_roughness=roughness, azimuthal_roughness=roughness)
            found = sample(material, wo, tangent, kind(0.5), corners.astype(kind))
            assert all(np.isfinite(each).all() and each.dtype == kind for each in found)


# --- Longitudinal scattering ---


def test_scaled_bessel_function():
    x = np.concatenate([np.linspace(0, 20, 400), np.geomspace(20, 600, 50)])
    assert scaled_i0(x) == pytest.approx(np.i0(x) * np.exp(-x), rel=5e-7)
    assert scaled_i0(np.array([1e8])) == pytest.approx(1 / math.sqrt(2e8 * math.pi), rel=1e-6)


@pytest.mark.parametrize("variance", [1e-6, 1e-3, 0.1, 1.0, 50.0])
def test_longitudinal_density_integrates_to_one(variance):
    for theta_o in (0.0, 0.9, -1.5):
        # A fine grid of angles around the peak at -θo, and a coarse one elsewhere.
        width = min(10 * math.sqrt(variance), 0.5)
        grid = np.linspace(max(-theta_o - width, -math.pi / 2), min(-theta_o + width, math.pi / 2), 4001)
        theta = np.unique(np.concatenate([np.linspace(-math.pi / 2, math.pi / 2, 4001), grid]))
        density = longitudinal(np.sin(theta), np.cos(theta), np.sin(theta_o), np.cos(theta_o), variance)
        values = density * np.cos(theta)
        assert (0.5 * (values[1:] + values[:-1]) * np.diff(theta)).sum() == pytest.approx(1, abs=1e-4)


# --- Symmetries ---


def test_mirrors():
    material, straight = HairMaterial(scale_tilt=4), HairMaterial(scale_tilt=-4)
    rng = np.random.default_rng(5)
    sin_o, sin_i, h = rng.uniform(-1, 1, (3, 500))
    phi = rng.uniform(-np.pi, np.pi, 500)
    value = evaluate_angles(material, sin_o, sin_i, phi, h)
    assert evaluate_angles(material, sin_o, sin_i, -phi, -h) == pytest.approx(value, rel=1e-9)
    assert evaluate_angles(material, sin_o, sin_i, phi + 4 * np.pi, h) == pytest.approx(value, rel=1e-9)
    assert evaluate_angles(straight, -sin_o, -sin_i, phi, h) == pytest.approx(value, rel=1e-9)


def test_tilt_moves_the_reflection_towards_the_tangent():
    sine = np.linspace(-1, 1, 4001)
    for tilt in (-5, 0, 5):
        material = HairMaterial((50, 50, 50), 0.1, scale_tilt=tilt)  # only R is left
        value = evaluate_angles(material, 0.0, sine, 0.0, 0.0)[:, 0]
        assert math.degrees(math.asin(sine[value.argmax()])) == pytest.approx(2 * tilt, abs=0.3)


def test_directions_and_angles_agree():
    material = HairMaterial()
    wo, wi, tangent, h = random_rays(500, 6)
    value = evaluate(material, wo, wi, tangent, h)
    sin_o, sin_i = (wo * tangent).sum(axis=1), (wi * tangent).sum(axis=1)
    across_o, across_i = (w - s[:, None] * tangent for w, s in ((wo, sin_o), (wi, sin_i)))
    phi = np.arctan2((np.cross(across_o, across_i) * tangent).sum(axis=1), (across_o * across_i).sum(axis=1))
    assert evaluate_angles(material, sin_o, sin_i, phi, h) == pytest.approx(value, rel=1e-6)
    # The other direction of the tangent mirrors the offset and the tilt.
    assert evaluate(HairMaterial(scale_tilt=-2), wo, wi, -tangent, -h) == pytest.approx(value, rel=1e-9)


def test_offset_is_the_side_where_the_mirror_reflects():
    # A fibre along x is seen from z. Its point at y = +√½ has a normal at 45°, and reflects light from +y.
    wo, tangent, normal = np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), np.array([0, 1, 1]) / math.sqrt(2)
    side = np.cross(wo, tangent)
    h = float(normal @ side)
    smooth = HairMaterial((50, 50, 50), 0.1, 0.1, scale_tilt=0)
    lit = evaluate(smooth, wo, np.array([[0, 1.0, 0], [0, -1.0, 0]]), tangent, h)[:, 0]
    assert h == pytest.approx(math.sqrt(0.5))
    assert lit[0] > 1000 * lit[1]


# --- Input ---


def test_shapes_and_kinds():
    material = HairMaterial()
    wo, wi, tangent, h = random_rays(6)
    wide = evaluate(material, wo.reshape(2, 3, 3), wi.reshape(2, 3, 3), tangent[0], 0.3)
    assert wide.shape == (2, 3, 3)
    assert wide[1, 2] == pytest.approx(evaluate(material, wo[5], wi[5], tangent[0], 0.3))
    assert evaluate(material, wo[0], wi[0], tangent[0], 0.3).shape == (3,)
    assert evaluate(material, np.zeros((0, 3)), wi[0], tangent[0], 0.3).shape == (0, 3)
    single = [each.astype(np.float32) for each in (wo, wi, tangent, h)]
    value = evaluate(material, *single)
    assert value.dtype == np.float32
    assert value == pytest.approx(evaluate(material, wo, wi, tangent, h), rel=1e-3, abs=1e-5)
    assert evaluate(material, wo, *single[1:]).dtype == np.float64
    assert evaluate(material, wo, wi, tangent, 1.5) == pytest.approx(evaluate(material, wo, wi, tangent, 1.0))


def test_refused():
    material = HairMaterial()
    for wrong, says in (
        (lambda: evaluate(material, (0, 1), (0, 0, 1), (1, 0, 0), 0), r"wo has shape \(2,\); expected \(…, 3\)"),
        (lambda: evaluate(material, np.ones((2, 3)), np.ones((3, 3)), (1, 0, 0), 0), "do not fit together"),
        (lambda: pdf(material, (0, 0, 1), (0, 0, 1), "xyz", 0), "tangent"),
        (lambda: sample(material, (0, 0, 1), (1, 0, 0), 0, (0.5, 0.5)), "u4 has shape"),
        (lambda: evaluate_angles(material, 0, 0, None, 0), "phi"),
        (lambda: evaluate_angles(material, 0, [[0], [0, 1]], 0, 0), "sin_theta_i"),
    ):
        with pytest.raises(InputError, match=says):
            wrong()


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("roughness", [0.001, 0.3, 1.0])
def test_extreme_angles_have_finite_values(kind, roughness):
    for sigma_a in (CLEAR, (0.1, 1e3, 1e6)):
        material = HairMaterial(sigma_a, roughness, roughness, scale_tilt=20)
        some = np.array([-1, -1 + 1e-7, -0.5, 0, 1e-30, 1 - 1e-7, 1], kind)
        turns = np.array([0, np.pi, -np.pi, 100], kind)
        sin_o, sin_i, phi, h = (each.ravel() for each in np.meshgrid(some, some, turns, some))
        value = evaluate_angles(material, sin_o, sin_i, phi, h)
        assert np.isfinite(value).all()
        assert (value >= 0).all()
        axes = np.concatenate([np.eye(3), -np.eye(3), unit(np.array([[1, 1e-5, 0]]))]).astype(kind)
        wo, wi = (axes[each.ravel()] for each in np.meshgrid(np.arange(7), np.arange(7)))
        for offset in (-1, 0, 1):
            assert np.isfinite(evaluate(material, wo, wi, axes[0], kind(offset))).all()
            assert np.isfinite(pdf(material, wo, wi, axes[0], kind(offset))).all()
            u4 = np.full(4, 0.3, kind)
            assert all(np.isfinite(each).all() for each in sample(material, axes, axes[0], kind(offset), u4))


# --- Mitsuba ---


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("example", MITSUBA)
def test_values_of_mitsuba(example, kind):
    material = HairMaterial(**example["material"])
    rays = [np.asarray(each, kind) for each in (example["wo"], example["wi"], (0, 1, 0), example["h"])]
    # Mitsuba's Bessel function is off by up to 0.6 %, and its float32 where the value is next to nothing.
    assert evaluate(material, *rays) == pytest.approx(example["value"], rel=0.007, abs=1e-6)
    assert float(pdf(material, *rays)) == pytest.approx(example["pdf"], rel=0.007, abs=1e-6)
