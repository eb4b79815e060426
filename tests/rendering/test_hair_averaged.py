"""Hair averaged over its width: the tables beside sums over all offsets, attenuations, symmetries and input."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fastlines.errors import InputError
from fastlines.rendering.hair import AveragedHair, HairMaterial, evaluate_angles

MATERIALS = {
    "brown": HairMaterial.from_melanin(0.7),
    "red, rough": HairMaterial.from_melanin(0.5, redness=1, longitudinal_roughness=0.6, azimuthal_roughness=0.8),
    "smooth": HairMaterial((0.1, 0.3, 1.0), 0.2, 0.12, scale_tilt=5),
    "clear": HairMaterial((0, 0, 0), 0.3, 1.0, eta=1.3),
}


def mean_over_offsets(material, sin_o, sin_i, phi, n=1000):
    """Return ½ ∫ of the value over h, by the midpoint rule in γ with h = sin γ."""
    gamma = (np.arange(n) + 0.5) * (np.pi / n) - np.pi / 2
    value = evaluate_angles(material, sin_o[:, None], sin_i[:, None], phi[:, None], np.sin(gamma))
    return (value * np.cos(gamma)[:, None]).sum(axis=1) * (np.pi / n / 2)


def random_angles(n, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(-1, 1, n), rng.uniform(-1, 1, n), rng.uniform(-np.pi, np.pi, n)


@pytest.mark.parametrize("name", MATERIALS)
def test_tables_are_the_mean_over_offsets(name):
    material = MATERIALS[name]
    angles = random_angles(150)
    expected = mean_over_offsets(material, *angles)
    error = np.abs(AveragedHair(material).evaluate(*angles) - expected) / np.maximum(expected, 1e-4)
    assert np.median(error) < 1e-3
    assert np.quantile(error, 0.99) < 5e-3
    assert error.max() < 2e-2


def test_smoothest_hair_is_blurred_but_loses_nothing():
    material = HairMaterial((0, 0, 0), 0.3, 0.001)
    hair = AveragedHair(material)
    sine, phi = (np.arange(400) + 0.5) / 200 - 1, (np.arange(4000) + 0.5) * (np.pi / 2000)
    value = hair.evaluate(0.3, sine[:, None], phi)
    assert value.mean(axis=(0, 1)) * 4 * np.pi == pytest.approx([1, 1, 1], abs=0.005)


@pytest.mark.parametrize("name", MATERIALS)
def test_values_integrate_to_the_attenuations(name):
    material = MATERIALS[name]
    hair = AveragedHair(material)
    sine, phi = (np.arange(400) + 0.5) / 200 - 1, (np.arange(360) + 0.5) * (np.pi / 180) - np.pi
    for sin_o in (0.0, -0.6, 0.95):
        value = hair.evaluate(sin_o, sine[:, None], phi)
        cell = 4 * np.pi / value[..., 0].size
        onwards = np.abs(phi)[:, None] / np.pi
        assert (value * onwards).sum(axis=(0, 1)) * cell == pytest.approx(hair.forward(sin_o), abs=0.004)
        assert (value * (1 - onwards)).sum(axis=(0, 1)) * cell == pytest.approx(hair.backward(sin_o), abs=0.004)


def test_attenuations_are_those_of_half_spaces():
    """Zinke et al., eq. 6: the mean over directions of light in a half space, of what goes to the other half space."""
    material = MATERIALS["brown"]
    hair = AveragedHair(material)
    rng = np.random.default_rng(1)
    n, sin_o = 400_000, 0.4
    light, sine, phi = rng.uniform(-np.pi / 2, np.pi / 2, n), rng.uniform(-1, 1, n), rng.uniform(-np.pi, np.pi, n)
    value = hair.evaluate(sin_o, sine, phi - light) * (4 * np.pi)
    goes_back = np.abs(phi) < np.pi / 2
    assert (value * ~goes_back[:, None]).mean(axis=0) == pytest.approx(hair.forward(sin_o), abs=0.01)
    assert (value * goes_back[:, None]).mean(axis=0) == pytest.approx(hair.backward(sin_o), abs=0.01)


def test_energy_balance():
    sine = np.linspace(-1, 1, 41)
    for roughness in (0.05, 0.3, 1.0):
        clear = AveragedHair(HairMaterial((0, 0, 0), 0.3, roughness))
        assert clear.forward(sine) + clear.backward(sine) == pytest.approx(1, abs=1e-4)
    brown = AveragedHair(MATERIALS["brown"])
    forward, backward = brown.forward(sine), brown.backward(sine)
    assert (forward + backward <= 1 + 1e-6).all()
    assert ((forward >= 0) & (backward >= 0)).all()
    assert (forward[20] > 0.05).all()
    darker = AveragedHair(dataclasses.replace(MATERIALS["brown"], sigma_a=(5, 5, 5)))
    assert (darker.forward(0.2) < brown.forward(0.2)).all()


def test_symmetries():
    hair, mirrored = (AveragedHair(HairMaterial(scale_tilt=tilt)) for tilt in (3, -3))
    sin_o, sin_i, phi = random_angles(500, 2)
    value = hair.evaluate(sin_o, sin_i, phi)
    assert hair.evaluate(sin_o, sin_i, -phi) == pytest.approx(value, rel=1e-3, abs=1e-6)
    assert hair.evaluate(sin_o, sin_i, phi + 2 * np.pi) == pytest.approx(value, rel=1e-3, abs=1e-6)
    assert mirrored.evaluate(-sin_o, -sin_i, phi) == pytest.approx(value, rel=1e-3, abs=1e-6)
    # Reciprocity holds where the model has it: without a tilt, for equal inclinations.
    level = AveragedHair(HairMaterial(scale_tilt=0))
    assert level.evaluate(sin_o, -sin_o, phi) == pytest.approx(level.evaluate(-sin_o, sin_o, -phi), rel=1e-3, abs=1e-6)


def test_shapes_and_extreme_input():
    hair = AveragedHair(HairMaterial())
    assert hair.evaluate(0.1, 0.2, 0.3).shape == (3,)
    assert hair.evaluate(np.zeros((4, 1)), np.zeros(5), 0.3).shape == (4, 5, 3)
    assert hair.evaluate([], 0.0, 0.0).shape == (0, 3)
    assert hair.forward(np.zeros((2, 2))).shape == (2, 2, 3)
    assert hair.evaluate(0.1, 0.2, 0.3).dtype == hair.backward(0.5).dtype == np.float32
    ends = np.array([-1, -0.0, 1, 1 + 1e-6])
    values = hair.evaluate(ends[:, None, None], ends[:, None], [0, np.pi, -np.pi, 4 * np.pi, 1e4])
    assert np.isfinite(values).all()
    assert (values >= 0).all()
    assert np.isnan(hair.evaluate([0.1, np.nan, 0.1], [np.nan, 0.1, 0.1], [0.1, 0.1, np.nan])).all()
    with pytest.raises(InputError, match="do not fit together"):
        hair.evaluate(np.zeros(2), np.zeros(3), 0.0)


def test_hair_is_a_value():
    assert AveragedHair(HairMaterial()) == AveragedHair(HairMaterial())
    assert "table" not in repr(AveragedHair(HairMaterial()))
