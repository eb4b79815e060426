"""The round cones that curves are cut into: within the tolerance, joined bit for bit, and found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.curves import SHAPES, bernstein, curves_of, errors, float32_rounding

import fastlines as fl
from fastlines.geometry.curve_pieces import LEAST_LOCAL, OF_BOX, OF_RADIUS, ROUNDING


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("shape", SHAPES)
def test_pieces_stay_within_the_default_tolerance(shape: str, scale: float) -> None:
    curves = curves_of(shape, scale)
    off, least = errors(curves)
    control = curves.control.astype(np.float64)
    most = (
        np.zeros(len(curves))
        if curves.radius is None
        else curves.evaluate(np.arange(len(curves))[:, None], np.linspace(0, 1, 1001)).radius.max(axis=1) * (1 + 1e-5)
    )
    box = OF_BOX * (np.ptp(control, axis=1).max(axis=1) + 2 * most)
    of = curves.pieces.curve
    local = OF_RADIUS * np.maximum(least, LEAST_LOCAL * most[of])
    allowed = np.where(most[of] > 0, np.minimum(box[of], local), box[of])
    allowed = np.maximum(allowed, ROUNDING * np.abs(control).max(axis=(1, 2))[of])
    assert (off <= allowed + float32_rounding(curves)).all()
    assert (off <= curves.pieces.deviation + float32_rounding(curves)).all()
    assert (curves.pieces.deviation <= allowed * (1 + 1e-9)).all()
    assert np.bincount(of).max() <= 2048


@pytest.mark.parametrize("tolerance", [0.3, 1e-2, 1e-4])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("shape", SHAPES)
def test_pieces_stay_within_a_tolerance_that_is_given(shape: str, scale: float, tolerance: float) -> None:
    curves = curves_of(shape, scale, tolerance * scale)
    assert errors(curves)[0].max() <= tolerance * scale + float32_rounding(curves)
    assert (curves.pieces.deviation <= tolerance * scale).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_pieces_tile_their_curves(shape: str) -> None:
    curves = curves_of(shape)
    pieces, first = curves.pieces, curves.pieces.first
    assert first[0] == 0
    assert first[-1] == len(pieces) == len(pieces.lines)
    assert np.array_equal(pieces.curve, np.repeat(np.arange(len(curves)), np.diff(first)))
    assert (pieces.begin[first[:-1]] == 0).all()
    assert (pieces.end[first[1:] - 1] == 1).all()
    assert (pieces.begin < pieces.end).all()
    inner = np.delete(np.arange(len(pieces)), first[:-1])
    assert np.array_equal(pieces.begin[inner], pieces.end[inner - 1])
    segments, radius = pieces.lines.segments, pieces.lines.radius
    assert np.array_equal(segments[inner, 0], segments[inner - 1, 1])
    assert np.array_equal(segments[first[:-1], 0], curves.control[:, 0])
    assert np.array_equal(segments[first[1:] - 1, 1], curves.control[:, 3])
    if curves.radius is None:
        assert radius is None
    else:
        assert np.array_equal(radius[inner, 0], radius[inner - 1, 1])
        assert (radius >= 0).all()
        assert radius.max() <= np.float32(curves.max_radius)
    low, high = curves.bounds
    assert (segments >= low).all()
    assert (segments <= high).all()


def test_pieces_are_as_many_as_needed() -> None:
    def count(shape: str, tolerance: float | None = None) -> list[int]:
        return np.diff(curves_of(shape, tolerance=tolerance).pieces.first).tolist()

    assert count("straight") == count("straight, tapered") == count("a point") == [1]
    assert count("a quarter") == [58]  # a chord of 1/56 is off by (π/2/56)²/8 = 9.8e-5, and 1 % of .01 are 1e-4
    assert count("a quarter", 1e-3) == [19]  # a chord of 1/18 is off by 9.5e-4
    assert count("a quarter", 1.0) == [1]
    # The straight part of a curve takes fewer pieces than the bend.
    bent = fl.Curves.from_bezier([[[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0]]], tolerance=1e-3).pieces
    lengths = bent.end - bent.begin
    assert lengths[0] > lengths[-1]


def test_straight_curves_are_one_piece_wherever_they_are() -> None:
    rng = np.random.default_rng(8)
    start, step = rng.normal(size=(2, 500, 1, 3)) * 10.0 ** rng.uniform(-3, 3, (2, 500, 1, 1))
    curves = fl.Curves.from_bezier((start + step * np.arange(4)[:, None]).astype(np.float32), radius=1e-9)
    assert len(curves.pieces) == 500


def test_a_point_is_its_largest_ball() -> None:
    pieces = curves_of("a point").pieces
    assert pieces.lines.segments.tolist() == [[[1, 1, 1], [1, 1, 1]]]
    t = np.linspace(0, 1, 100_001)
    assert np.allclose(pieces.lines.radius, bernstein(np.array([[0.1, 0.9, 0.7, 0.2]]), t).max())


@pytest.mark.parametrize("basis", ["bspline", "catmull-rom", "hermite"])
def test_curves_of_a_strand_meet_bit_for_bit(basis: str) -> None:
    points = np.random.default_rng(5).normal(size=(50, 3)) * 1e3
    radius = np.random.default_rng(6).uniform(size=50)
    tangents = points[::-1] if basis == "hermite" else None
    for wrap in ("nonperiodic", "periodic"):
        made = fl.Curves.from_strands(
            points, [50], basis=basis, wrap=wrap, radius=radius, tangents=tangents, tolerance=9
        )
        for values in (made.control, made.radius):
            assert np.array_equal(values[1:, 0], values[:-1, 3])
            assert wrap == "nonperiodic" or np.array_equal(values[0, 0], values[-1, 3])
        segments, radii = made.pieces.lines.segments, made.pieces.lines.radius
        assert np.array_equal(segments[1:, 0], segments[:-1, 1])
        assert np.array_equal(radii[1:, 0], radii[:-1, 1])


def test_catmull_rom_radii_do_not_pass_zero() -> None:
    points = np.random.default_rng(4).normal(size=(6, 3))
    curves = fl.Curves.from_strands(points, [6], basis="catmull-rom", radius=[1, 0, 0, 1, 0, 0], tolerance=1e-3)
    assert curves.radius.min() < 0
    assert (curves.evaluate([[0], [1], [2]], np.linspace(0, 1, 99)).radius >= 0).all()
    assert (curves.pieces.lines.radius >= 0).all()
    assert errors(curves)[0].max() <= 1e-3 + float32_rounding(curves)
    again = replace(curves, tolerance=1e-2)
    assert len(again.pieces) < len(curves.pieces)


def test_a_tolerance_that_cannot_be_reached_is_reported() -> None:
    curves = curves_of("a quarter", tolerance=1e-12)
    with pytest.warns(
        fl.PrecisionWarning, match=r"1 of 1 curves \(row 0\) are off by up to \d.*e-0\d, more than their"
    ):
        pieces = curves.pieces
    assert len(pieces) == 4096
    assert 1e-12 < pieces.deviation.max() < 1e-7
    assert curves.pieces is pieces


def test_places_are_found_on_pieces_and_back() -> None:
    curves = curves_of("random")
    rng = np.random.default_rng(10)
    curve = rng.integers(0, len(curves), (50, 40))
    u = rng.uniform(size=curve.shape).astype(np.float32)
    u[0] = np.linspace(0, 1, 40)  # ends of pieces are among these
    u[1] = rng.integers(0, 4097, 40) / 4096
    u[2] = np.float32(1) - np.float32(2.0**-24)
    u[3], u[4], u[5] = 0, 1, 2.0**-149
    piece, s = curves.locate(curve, u)
    pieces = curves.pieces
    assert piece.shape == s.shape == curve.shape
    assert ((s >= 0) & (s <= 1)).all()
    assert np.array_equal(pieces.curve[piece], curve)
    assert ((pieces.begin[piece] <= u) & (u <= pieces.end[piece])).all()
    back_curve, back_u = curves.parameter(piece, s)
    assert back_u.dtype == np.float32
    assert np.array_equal(back_curve, curve)
    assert np.array_equal(back_u, u)
    assert np.array_equal(piece[3], pieces.first[curve[3]])
    assert np.array_equal(piece[4], pieces.first[curve[4] + 1] - 1)
    # The point of the piece is that of the curve, up to the tolerance.
    ends = pieces.lines.segments[piece].astype(np.float64)
    chord = ends[..., 0, :] + s[..., None] * (ends[..., 1, :] - ends[..., 0, :])
    gap = np.linalg.norm(chord - curves.evaluate(curve, u).points, axis=-1)
    assert (gap <= pieces.deviation[piece] + float32_rounding(curves)).all()


def test_queries_take_the_pieces() -> None:
    """A ray hits the swept circle where a torus is."""
    curves = fl.Curves.from_strands(
        [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]],
        [4],
        basis="hermite",
        wrap="periodic",
        tangents=np.array([[0, 1, 0], [-1, 0, 0], [0, -1, 0], [1, 0, 0]]) * 4 * 0.5522847 * 0.75,
        radius=0.1,
    )
    angle = np.linspace(0.1, 6.2, 50)
    origins = np.stack([np.cos(angle), np.sin(angle), np.full(50, -5.0)], axis=1)
    hits = fl.build(curves.pieces.lines).first_hit(origins, [0, 0, 1], at="surface")
    assert np.allclose(hits.t, 4.9, atol=1e-3)
    curve, u = curves.parameter(hits.prim, hits.u)
    assert np.allclose(curves.evaluate(curve, u).points, origins - origins[:, 2:] * [0, 0, 1], atol=2e-3)
