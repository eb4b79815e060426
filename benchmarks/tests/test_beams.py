"""The command ``beams`` at a tiny size, and its theory."""

from __future__ import annotations

import importlib.util
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused
from peers import needs_embree

from fastlines_bench.beams.caustic import OURS, REFERENCE, THEIRS, CausticSize, _figures, _time_of
from fastlines_bench.beams.closed_form import blurred, radiance
from fastlines_bench.beams.reference import Reference

pytestmark = pytest.mark.usefixtures("in_own_folder")

needs_compiler = pytest.mark.skipif(
    not (shutil.which("g++") or shutil.which("c++")), reason="there is no compiler for the loops"
)
HAS_MITSUBA = importlib.util.find_spec("mitsuba") is not None
needs_mitsuba = pytest.mark.skipif(not HAS_MITSUBA, reason="Mitsuba is not installed")


def parts_of(path: str):
    result = json.loads(Path(path).read_text())
    assert result["format"] == "fastlines-bench beams 1"
    return {part["name"]: part for part in result["parts"]}


def test_closed_form_is_the_integral_along_the_ray():
    b, h = np.array([0.05, 0.7]), np.array([0.9, 0.5])
    t = (np.arange(1_000_000) + 0.5) / 1_000_000 * 2 * h[:, None]
    r = np.sqrt(b[:, None] ** 2 + (t - h[:, None]) ** 2)
    expected = (2.0 * 0.8 / (4 * np.pi) ** 2 / r**2 * np.exp(-1.2 * (t + r))).mean(axis=1) * 2 * h
    np.testing.assert_allclose(radiance(b, h, 2.0, 0.8, 1.2), expected, rtol=1e-6)


def test_blur_of_the_inverse_distance():
    # Without extinction and for a long ray, L is c/b, and its blur c/b · arcsin(R/b)/(R/b).
    b, h = np.array([0.3, 2.0]), np.full(2, 1e6)
    ratio = blurred(b, h, 0.2, 1.0, 1.0, 0.0) / radiance(b, h, 1.0, 1.0, 0.0)
    np.testing.assert_allclose(ratio, np.arcsin(0.2 / b) / (0.2 / b), rtol=1e-5)


def test_time_of_an_error():
    curve = [(1.0, 0.4), (4.0, 0.1)]
    assert [_time_of(curve, error) for error in (0.5, 0.2, 0.05)] == [1.0, pytest.approx(2.0), None]


def noisy_reference() -> tuple[np.ndarray, Reference]:
    """Return a picture, and a reference whose halves have grey noise of deviation 0.2; its last row does not count."""
    rng = np.random.default_rng(5)
    truth = rng.uniform(1, 3, (65, 64, 3))
    quarters = truth + rng.normal(0, 0.2 * 2**0.5, (4, *truth.shape[:2], 1))
    quarters[0, 64] += 100
    counted = np.ones(truth.shape[:2], bool)
    counted[64] = False
    return truth, Reference(list(quarters), counted)


def test_an_error_is_without_the_noise_of_the_reference():
    truth, reference = noisy_reference()
    assert reference.mean == pytest.approx(2, abs=0.02)
    for off in (0.2, 0.5):
        assert reference.error(truth + off) == pytest.approx(off / 2, rel=0.05)
    # The picture's own noise is part of its error, and does not raise the floor.
    noise = np.random.default_rng(6).normal(0, 0.5, truth.shape)
    assert reference.error(truth + noise) == pytest.approx(0.25, rel=0.05)


def test_the_least_error_follows_from_the_noise_of_the_reference():
    truth, reference = noisy_reference()
    # The standard error of the mean of 64² products is the variance of a half by 64.
    assert reference.floor == pytest.approx((2 * 0.2**2 / 64) ** 0.5 / 2, rel=0.05)
    assert reference.error(truth) == reference.floor


@pytest.mark.parametrize(("theirs", "share"), [(0.04, 0.5), (None, None)])
def test_an_error_at_the_floor_is_not_compared(theirs, share):
    truth, reference = noisy_reference()
    last = theirs or reference.floor
    curves = {OURS: [(1.0, 0.08), (4.0, 0.02)], THEIRS: [(4.0, last)]}
    pictures = {name: truth.copy() for name in (OURS, THEIRS, REFERENCE)}
    size = CausticSize(64, 1000, 0.1, 4.0, 16.0, "llvm_ad_rgb", floors=True, n_threads=1)
    figures = _figures(size, curves, pictures, reference, "3.9", 1000)
    sooner = figures.checks[1]
    assert sooner.figure == (None if share is None else pytest.approx(share))
    assert sooner.holds is (None if share is None else False)
    assert ("is the least that the reference resolves" in figures.notes[1]) == (share is None)


def test_point_light():
    text = done("beams", "--quick", "--part", "point-light", "--json", "b.json", "--plot", "b.png")
    assert "a point light in a medium" in text
    part = parts_of("b.json")["point-light"]
    assert len(part["rows"]) == 11
    assert all(check["holds"] for check in part["checks"]), part["checks"]
    assert Path("b.png").stat().st_size > 10_000


@needs_embree
@needs_compiler
def test_gathers_agree():
    done("beams", "--quick", "--part", "gather,passes,radii", "--size", 32, "--passes", 2, "--json", "b.json")
    parts = parts_of("b.json")
    assert [row[2] for row in parts["gather"]["rows"]] == ["ours", "lists + NumPy", "Embree", "grid", "brute force"]
    assert len(parts["passes"]["rows"]) == len(parts["radii"]["rows"]) == 2
    assert [len(part["checks"]) for part in parts.values()] == [4, 1, 1]
    for part in parts.values():
        assert all(check["holds"] for check in part["checks"]), part["checks"]


@needs_mitsuba
@pytest.mark.slow
def test_caustic():
    done("beams", "--quick", "--part", "caustic", "--seconds", 0.5, "--json", "b.json", "--plot", "b.png")
    points = parts_of("b.json")["caustic"]["points"]
    assert {point["side"] for point in points} == {"fastlines", "Mitsuba"}
    assert all(point["rmse"] >= 0 for point in points)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--part", "gathr"], "did you mean 'gather'"),
        (["--beams", "0"], "--beams '0' is not a whole number from 1"),
        (["--part", "gather", "--plot", "b.png"], "--plot draws point-light, passes, caustic"),
        (["--variant", "cuda_rgb"], "--variant 'cuda_rgb' is not a variant"),
    ],
)
def test_refused(arguments, said):
    assert said in refused("beams", "--quick", *arguments)[1]


@pytest.mark.skipif(HAS_MITSUBA, reason="Mitsuba is installed")
def test_a_missing_peer_is_said_before_the_work():
    assert "pip install mitsuba" in refused("beams", "--quick", "--part", "point-light,caustic")[1]
