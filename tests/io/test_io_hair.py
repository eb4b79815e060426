"""Readers of hair: every combination of arrays that .hair and .tfx files can hold, from hand-written bytes."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from support.line_files import FIRST, LAST, POINTS, STRANDS, hair, tfx


@pytest.mark.parametrize("bits", [bits for bits in range(64) if bits & 2])
def test_hair_with_every_combination_of_arrays(load, bits):
    if bits & 1:
        lines = load(hair(bits=bits, thickness=0.5), "a.hair")
        first, last, strands = FIRST, LAST, STRANDS
    else:
        lines = load(hair(bits=bits, strands=1, segments=6, thickness=0.5), "a.hair")
        first, last, strands = range(6), range(1, 7), [0] * 6
    ends = np.stack([first, last], axis=1)
    assert lines.segments.dtype == np.float32
    np.testing.assert_array_equal(lines.segments, POINTS[ends])
    np.testing.assert_array_equal(lines.strands, strands)
    np.testing.assert_array_equal(lines.radius, ends / 2 if bits & 4 else np.full(ends.shape, 0.25))
    expected = {"transparency": bits & 8, "color": bits & 16, "uv": bits & 32}
    assert set(lines.attributes) == {name for name, there in expected.items() if there}
    if bits & 8:
        np.testing.assert_allclose(lines.attributes["transparency"], np.linspace(0, 1, 7)[first], rtol=1e-6)
    if bits & 16:
        np.testing.assert_allclose(lines.attributes["color"], np.arange(21).reshape(7, 3)[first] / 21, rtol=1e-6)
    if bits & 32:
        np.testing.assert_allclose(lines.attributes["uv"], np.arange(14).reshape(7, 2)[first] / 14, rtol=1e-6)


@pytest.mark.parametrize("magic", [b"hair", b"Hair"])
def test_hair_whose_magic_is_in_lower_case(load, magic):
    assert len(load(hair(magic=magic), "a.hair")) == len(FIRST)


def test_hair_of_default_thickness_zero_has_no_radius(load):
    assert load(hair(thickness=0.0), "a.hair").radius is None


@pytest.mark.parametrize("version", [3, 4])
@pytest.mark.parametrize("gap", [0, 24])
@pytest.mark.parametrize(
    "optional",
    [names for n in range(5) for names in itertools.combinations(("thickness", "strand_uv", "uv", "color"), n)],
)
def test_tfx_with_every_combination_of_arrays(load, version, gap, optional):
    lines = load(tfx(version, optional=optional, gap=gap), "a.tfx")
    first = np.array([0, 1, 3, 4])
    np.testing.assert_array_equal(lines.segments, POINTS[np.stack([first, first + 1], axis=1)])
    np.testing.assert_array_equal(lines.strands, [0, 0, 1, 1])
    if "thickness" in optional:
        np.testing.assert_array_equal(lines.radius, [[0.25] * 2, [0.25] * 2, [1] * 2, [1] * 2])
    else:
        assert lines.radius is None
    expected = {
        "strand_uv": np.arange(4).reshape(2, 2)[[0, 0, 1, 1]] / 4,
        "uv": np.arange(12).reshape(6, 2)[first] / 12,
        "color": np.arange(24).reshape(6, 4)[first] / 24,
        "inverse_mass": first,
    }
    assert set(lines.attributes) == {*optional, *["inverse_mass"] * (version == 4)} - {"thickness"}
    for name, values in lines.attributes.items():
        np.testing.assert_allclose(values, expected[name], rtol=1e-6)


def test_tfx_makes_up_no_follow_hairs_and_ignores_what_no_offset_points_to(load):
    lines = load(tfx(3, tail=b"what follows"), "a.tfx")
    assert (lines.n_strands, len(lines)) == (2, 4)


def test_strand_of_one_vertex_is_a_segment_of_zero_length(load):
    lines = load(tfx(3, strands=6, vertices=1, optional=("uv",)), "a.tfx")
    np.testing.assert_array_equal(lines.segments, np.stack([POINTS[:6]] * 2, axis=1))
