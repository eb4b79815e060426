"""Compiled scattering of hair beside the formulas in float64, over a grid of materials and at extreme angles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fastlines.rendering.hair import AveragedHair, HairMaterial, evaluate, evaluate_angles, frame, pdf, sample
from fastlines.rendering.hair.longitudinal import longitudinal
from fastlines.rendering.hair.table import azimuth_table
from fastlines.threads import num_threads

MATERIALS = {
    "brown": HairMaterial(),
    "clear": HairMaterial((0, 0, 0)),
    "rough": HairMaterial((0.2, 0.6, 2.0), 1.0, 1.0),
    "smooth": HairMaterial((0.2, 0.6, 2.0), 0.1, 0.2, scale_tilt=-8),
    "black glass": HairMaterial((1, 50, 1e6), 0.2, 0.6, eta=4, scale_tilt=20),
    "thin": HairMaterial((0, 0.01, 0.1), 0.6, 0.3, eta=1.001),
}
#: How much compiled code may differ, as a fraction of a fibre's largest value.
TOLERANCE = 1e-5


def directions(rng, *shape):
    vectors = rng.normal(size=(*shape, 3))
    return (vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)).astype(np.float32)


def fibres(n, grazing=1.0, seed=0):
    """Return outgoing directions, near to the tangents if wanted, tangents and offsets in float32."""
    rng = np.random.default_rng(seed)
    tangent, h = directions(rng, n, 1), rng.uniform(-1, 1, (n, 1)).astype(np.float32)
    h[:4, 0] = 1, -1, 0, np.nextafter(np.float32(1), np.float32(0))
    wo = directions(rng, n, 1) * np.float32(grazing) + tangent * np.float32(1 - grazing)
    return wo / np.linalg.norm(wo, axis=-1, keepdims=True), tangent, h


def doubles(*arrays):
    return tuple(np.asarray(each, np.float64) for each in arrays)


def half_drawn(material, wo, tangent, h, n=100):
    """Return directions of light in float32, (…, 2n, 3): n are drawn by the material, the others evenly."""
    rng = np.random.default_rng(1)
    drawn, _, _ = sample(material, *doubles(wo, tangent, h), rng.random((len(wo), n, 4)))
    return np.concatenate([drawn.astype(np.float32), directions(rng, len(wo), n)], axis=1)


def largest_difference(compiled, reference, wo, wi, tangent, h):
    """Return how much values of fibres (n, directions, …) differ, as a fraction of each fibre's largest value.

    Rounding turns directions around the tangent by about 1e-7 over the cosine of their inclination. So differences
    count times the smaller cosine.
    """
    assert compiled.dtype == np.float32
    cosines = (np.linalg.norm(np.cross(each, tangent), axis=-1) for each in doubles(wo, wi))
    cosine = np.minimum(*cosines).reshape(reference.shape[:2] + (1,) * (reference.ndim - 2))
    return float((np.abs(compiled - reference) * cosine / reference.max(axis=1, keepdims=True)).max())


@pytest.mark.parametrize("name", MATERIALS)
def test_values_and_densities_are_those_of_the_formulas(name):
    material, (wo, tangent, h) = MATERIALS[name], fibres(200)
    rays = wo, half_drawn(material, wo, tangent, h), tangent, h
    for function in (evaluate, pdf):
        assert largest_difference(function(material, *rays), function(material, *doubles(*rays)), *rays) < TOLERANCE


@pytest.mark.parametrize("grazing", [0.1, 0.01, 1e-3])
def test_light_that_leaves_along_the_fibre(grazing):
    material, (wo, tangent, h) = HairMaterial(), fibres(200, grazing)
    rays = wo, half_drawn(material, wo, tangent, h), tangent, h
    assert largest_difference(evaluate(material, *rays), evaluate(material, *doubles(*rays)), *rays) < 1e-4


@pytest.mark.parametrize("roughness", [(0.001, 0.3), (0.3, 0.001), (0.001, 0.001)])
def test_smoothest_lobes_are_as_sharp_as_float32(roughness):
    material, (wo, tangent, h) = HairMaterial((0.2, 0.6, 2.0), *roughness), fibres(200)
    rays = wo, half_drawn(material, wo, tangent, h), tangent, h
    # Lobes are about 2e-4 wide, and rounding moves them by 3e-7.
    assert largest_difference(evaluate(material, *rays), evaluate(material, *doubles(*rays)), *rays) < 5e-3


@pytest.mark.parametrize("name", MATERIALS)
def test_samples_are_those_of_the_formulas(name):
    material, (wo, tangent, h) = MATERIALS[name], fibres(2000)
    u4 = np.random.default_rng(2).random((2000, 1, 4)).astype(np.float32)
    wi, weight, density = sample(material, wo, tangent, h, u4)
    expected, expected_weight, _ = sample(material, *doubles(wo, tangent, h, u4))
    assert np.linalg.norm(wi, axis=-1) == pytest.approx(1, abs=5e-7)
    # A number between two lobes may choose the other one.
    same = np.linalg.norm(wi - expected, axis=-1) < 3e-5
    assert same.mean() > 0.998
    assert weight[same] == pytest.approx(expected_weight[same], rel=2e-3, abs=1e-6)
    # The density and the weight are those of the direction that is returned.
    rays = wo, wi, tangent, h
    assert density.tolist() == pdf(material, *rays).tolist()
    assert weight * density[..., None] == pytest.approx(evaluate(material, *rays), rel=1e-6)


@pytest.mark.parametrize(("longitudinal_roughness", "azimuthal_roughness"), [(0.3, 0.3), (0.1, 0.2), (1.0, 1.0)])
def test_white_furnace_and_densities_in_float32(longitudinal_roughness, azimuthal_roughness):
    sine, phi = np.meshgrid((np.arange(400) + 0.5) / 200 - 1, (np.arange(200) + 0.5) * (np.pi / 100))
    cosine = np.sqrt(1 - sine**2)
    wi = np.stack([sine, cosine * np.cos(phi), cosine * np.sin(phi)], axis=-1).astype(np.float32)
    along = np.array([1, 0, 0], np.float32)
    clear = HairMaterial((0, 0, 0), longitudinal_roughness, azimuthal_roughness, scale_tilt=4)
    brown = HairMaterial((0.2, 0.5, 1.5), longitudinal_roughness, azimuthal_roughness)
    for sin_o, h in ((0.0, -0.9), (0.5, 0.2), (-0.97, 0.6)):
        wo = np.array([sin_o, 0, math.sqrt(1 - sin_o**2)], np.float32)
        mean = evaluate(clear, wo, wi, along, np.float32(h)).mean(axis=(0, 1), dtype=np.float64)
        assert mean * 4 * math.pi == pytest.approx([1, 1, 1], abs=0.003)
        density = pdf(brown, wo, wi, along, np.float32(h)).mean(dtype=np.float64)
        assert density * 4 * math.pi == pytest.approx(1, abs=0.003)


def test_any_number_of_rows_and_layout_of_arrays():
    material, (wo, tangent, h) = HairMaterial(), fibres(40)
    rays = wo, half_drawn(material, wo, tangent, h, 1)[:, :1], tangent, h
    value = evaluate(material, *rays)
    for n in (0, 1, 15, 16, 17, 33):
        assert evaluate(material, *(each[:n] for each in rays)).tolist() == value[:n].tolist()
    assert evaluate(material, *(each[::3] for each in rays)).tolist() == value[::3].tolist()
    assert evaluate(material, *(np.asfortranarray(each) for each in rays)).tolist() == value.tolist()
    assert np.isnan(evaluate(material, wo, wo * np.float32(math.nan), tangent, h)).all()


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_batches_of_rows_have_the_same_values(kind, monkeypatch):
    material, (wo, tangent, h) = HairMaterial(scale_tilt=3), fibres(250)
    wi, averaged = half_drawn(material, wo, tangent, h, 1), AveragedHair(material)
    wo, wi, tangent, h = (each.astype(kind) for each in (wo, wi, tangent, h))
    u4 = np.random.default_rng(4).random((250, 2, 4)).astype(kind)
    sin_o, sin_i = wo[..., 0], wi[..., 0]

    def all_values():
        yield evaluate(material, wo, wi, tangent, h)
        yield pdf(material, wo, wi, tangent, h)
        yield from sample(material, wo, tangent, h, u4)
        yield evaluate_angles(material, sin_o, sin_i, u4[..., 0], h)
        yield averaged.evaluate(sin_o, sin_i, u4[..., 0])
        yield from averaged.attenuations(sin_i)

    whole = list(all_values())
    for rows, n_threads in ((37, 1), (160, 3), (499, 2)):
        monkeypatch.setattr(frame, "ROWS", rows)
        with num_threads(n_threads):
            found = list(all_values())
        for each, expected in zip(found, whole, strict=True):
            assert each.dtype == expected.dtype
            assert each.shape == expected.shape
            assert each.tobytes() == expected.tobytes()


# --- The far field ---


def interpolated(material, sin_o, sin_i, phi):
    """Return the values of tables between their ends, in float64, without what speed needs."""
    table = azimuth_table(material)
    n_rows, n_columns, _ = table.values.shape
    cos_o, cos_i = np.sqrt(1 - sin_o**2), np.sqrt(1 - sin_i**2)
    x = np.abs((phi + np.pi) % (2 * np.pi) - np.pi) * ((n_columns - 1) / np.pi)
    y = (cos_o + cos_o**2) / 2 * (n_rows - 1)
    column, row = (np.minimum(at.astype(int), n - 2) for at, n in ((x, n_columns), (y, n_rows)))
    x, y = (x - column)[:, None], (y - row)[:, None]
    values = np.asarray(table.values, np.float64)
    upper, lower = (values[r, column] * (1 - x) + values[r, column + 1] * x for r in (row, row + 1))
    around = upper * (1 - y) + lower * y
    rest = table.rest[row] * (1 - y) + table.rest[row + 1] * y
    value = np.zeros((len(phi), 3))
    channels = around[:, :1], around[:, 1:4], around[:, 4:7], rest
    for lobe, tilt, variance in zip(channels, material.tilts, material.variances, strict=True):
        tilted = sin_o * math.cos(tilt) + cos_o * math.sin(tilt)
        across = np.abs(cos_o * math.cos(tilt) - sin_o * math.sin(tilt))
        value += lobe * longitudinal(sin_i, cos_i, tilted, across, variance)[:, None]
    return value


@pytest.mark.parametrize("name", MATERIALS)
def test_averages_are_interpolated_in_tables(name):
    rng = np.random.default_rng(3)
    sin_o, sin_i, phi = (rng.uniform(-end, end, 4000).astype(np.float32) for end in (1, 1, 9))
    sin_o[:3], phi[3:6] = (-1, 0, 1), (0, np.pi, -np.pi)
    value = AveragedHair(MATERIALS[name]).evaluate(sin_o, sin_i, phi)
    expected = interpolated(MATERIALS[name], *doubles(sin_o, sin_i, phi))
    assert (np.abs(value - expected) / expected.max(axis=0)).max() < 1e-5
