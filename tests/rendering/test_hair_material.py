"""Materials of hair: colours, the shapes of lobes, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fastlines.errors import InputError
from fastlines.rendering.hair import HairMaterial
from fastlines.rendering.hair.absorption import absorption_of_pigments, absorption_of_reflectance, concentrations


def test_melanin_darkens_and_redness_turns_red():
    dark = [sum(HairMaterial.from_melanin(amount).sigma_a) for amount in (0, 0.2, 0.5, 0.9, 1)]
    assert dark == sorted(dark)
    assert dark[0] == 0
    assert dark[-1] < 30  # black, not opaque
    brown, red = HairMaterial.from_melanin(0.5).sigma_a, HairMaterial.from_melanin(0.5, redness=1).sigma_a
    assert red[2] / red[0] > brown[2] / brown[0]
    assert concentrations(0.5, 0.25) == pytest.approx((0.75 * math.log(2), 0.25 * math.log(2)))


def test_default_is_brown_as_in_pbrt():
    assert HairMaterial().sigma_a == pytest.approx(absorption_of_pigments(1.3), abs=1e-4)


def test_reflectance_is_that_of_the_paper():
    assert absorption_of_reflectance((1, 1, 1), 0.3) == (0, 0, 0)
    # At β_N = 0 the fit is ln(c) / 5.969, and at 1 the sum of all coefficients.
    assert absorption_of_reflectance((0.5, 0.5, 0.5), 0.0)[0] == pytest.approx((math.log(0.5) / 5.969) ** 2)
    whole = 5.969 - 0.215 + 2.532 - 10.73 + 5.574 + 0.245
    assert absorption_of_reflectance((0.5, 0.5, 0.5), 1.0)[1] == pytest.approx((math.log(0.5) / whole) ** 2)
    made = HairMaterial.from_reflectance(np.array([0.2, 0.5, 1.0]), azimuthal_roughness=0.5)
    assert made.azimuthal_roughness == 0.5
    assert made.sigma_a == absorption_of_reflectance((0.2, 0.5, 1.0), 0.5)


def test_shape_of_lobes():
    material = HairMaterial(longitudinal_roughness=1.0, azimuthal_roughness=1.0, scale_tilt=3.0)
    r, tt, trt, rest = material.variances
    assert r == pytest.approx((0.726 + 0.812 + 3.7) ** 2)
    assert (tt, trt, rest) == pytest.approx((r / 4, 4 * r, 4 * r))
    assert material.logistic_scale == pytest.approx(math.sqrt(math.pi / 8) * (0.265 + 1.194 + 5.372))
    assert np.degrees(material.tilts).tolist() == pytest.approx([-6, 3, 12, 0])


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"sigma_a": (1, 2)}, "three numbers"),
        ({"sigma_a": 1.0}, "three numbers"),
        ({"sigma_a": (1, 2, -1)}, "from 0 to 1e6"),
        ({"sigma_a": (1, 2, math.nan)}, "from 0 to 1e6"),
        ({"longitudinal_roughness": 0.0}, "0.001 to 1"),
        ({"azimuthal_roughness": 1.5}, "0.001 to 1"),
        ({"eta": 1.0}, "refractive index"),
        ({"scale_tilt": 90}, "degrees"),
    ],
)
def test_refused(wrong, says):
    with pytest.raises(InputError, match=says):
        HairMaterial(**wrong)


def test_refused_colours():
    for make in (
        lambda: HairMaterial.from_melanin(1.5),
        lambda: HairMaterial.from_melanin(0.5, redness=-1),
        lambda: HairMaterial.from_pigments(-1),
        lambda: HairMaterial.from_reflectance((0, 0.5, 0.5)),
        lambda: HairMaterial.from_reflectance("red!"),
    ):
        with pytest.raises(InputError):
            make()


def test_materials_are_values():
    assert HairMaterial((0, 1, 2)) == HairMaterial(np.array([0.0, 1.0, 2.0]))
    assert len({HairMaterial(), HairMaterial(), HairMaterial(eta=1.5)}) == 2
