"""Sums over all hits: the formula in float64, the same bits however they are found, and what is refused."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from support import forests
from support.builds import ALL_KINDS, METHODS, build

import fastlines as fl
from fastlines.query import gather, run_lists
from fastlines.threads import num_threads

RNG = np.random.default_rng(0)
SEGMENTS = (RNG.random((300, 1, 3)) + RNG.normal(0, 0.2, (300, 2, 3))).astype(np.float32)
THICK = fl.Lines.from_segments(SEGMENTS, radius=RNG.random((300, 2)) * 0.05)
ORIGINS = RNG.normal(0.5, 1, (200, 3)).astype(np.float32)
DIRECTIONS = (3 * (RNG.random((200, 3)) - ORIGINS)).astype(np.float32)
RAYS: dict[str, Any] = {"origins": ORIGINS, "directions": DIRECTIONS, "t_max": 0.5}
VALUES = RNG.normal(1, 0.5, (300, 3)).astype(np.float32)
#: All that a contribution depends on.
RULES: dict[str, dict[str, Any]] = {
    "counts": {"blur": "none"},
    "plain": {},
    "values": {"values": VALUES, "blur": "epanechnikov", "squares": True},
    "beams": {"values": VALUES, "sigma": [1, 2, 3], "line_sigma": [0.1, 0.2, 0.3], "phase": 0.6},
    "ends": {"inner": False, "sigma": 0.5, "phase": -0.9},
    "grid": {"values": VALUES[:, 0], "optical_depth": np.sort(RNG.random((200, 7)), axis=1), "squares": True},
    "grids": {"values": VALUES, "optical_depth": np.sort(RNG.random((200, 7, 3)), axis=1)},
}


@pytest.fixture(autouse=True)
def widest_simd() -> Iterator[None]:
    yield
    fl.set_simd(None)


def assert_same(got: fl.Gathered, expected: fl.Gathered) -> None:
    """Compare sums bit for bit."""
    for name in ("sum", "squares", "count"):
        a, b = getattr(got, name), getattr(expected, name)
        assert (a is None) == (b is None), name
        if a is not None:
            assert a.shape == b.shape, name
            assert a.tobytes() == b.tobytes(), name


def contributions(
    lines: fl.Lines, hits: fl.AllHits, rule: dict[str, Any], *, spread: float = 0.0, radius: Any = 0.05
) -> Any:
    """Return what each hit adds, in float64, (n_hits, n_channels); 0 for those that do not count."""
    rays = hits.rays
    assert rays is not None
    rule = {"values": np.ones(len(lines)), "blur": "box", "sigma": 0, "line_sigma": 0, "phase": None, **rule}
    ends = lines.segments.astype(np.float64)[hits.prim]
    along, t, u = ends[:, 1] - ends[:, 0], hits.t.astype(np.float64), hits.u.astype(np.float64)
    length, d = np.linalg.norm(along, axis=1), rays.directions.astype(np.float64)[hits.ray]
    cosine = (d * along).sum(axis=1) / length / np.linalg.norm(d, axis=1)
    depth = t * np.linalg.norm(d, axis=1)
    weight = np.ones(len(t))
    if rule["blur"] != "none":
        own = (lines.end_radii[hits.prim] * np.stack([1 - u, u], axis=1)).sum(axis=1)
        reach = own + np.broadcast_to(radius, len(rays))[hits.ray] + spread * depth
        shape = 0.5 if rule["blur"] == "box" else 0.75 * (1 - (hits.distance / reach) ** 2)
        weight = shape / reach / np.sqrt(1 - cosine**2)
    if (g := rule["phase"]) is not None:
        weight = weight * (1 - g * g) / (4 * np.pi * (1 + g * g + 2 * g * cosine) ** 1.5)
    absorbed = np.atleast_1d(rule["sigma"]) * depth[:, None]
    if "optical_depth" in rule:
        steps = np.linspace(0, 0.5, rule["optical_depth"].shape[1])
        tables = rule["optical_depth"].reshape(200, len(steps), -1)[hits.ray]
        absorbed = np.array(
            [[np.interp(at, steps, column) for column in table.T] for at, table in zip(t, tables, strict=True)]
        )
    absorbed = absorbed + np.atleast_1d(rule["line_sigma"]) * (u * length)[:, None]
    if rule.get("inner", True):
        weight = np.where((t > 0) & (t < 0.5) & (u > 0) & (u < 1), weight, 0)
    values = np.asarray(rule["values"], np.float64)[hits.prim]
    return weight[:, None] * values.reshape(len(t), -1) * np.exp(-absorbed)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("spread", [0.0, 0.02])
@pytest.mark.parametrize("lines", [fl.Lines.from_segments(SEGMENTS), THICK], ids=["thin", "thick"])
def test_sums_are_those_of_the_formula(lines: fl.Lines, spread: float, rule: str) -> None:
    tree, how = build(lines), {**RAYS, "radius": 0.05, "spread": spread}
    hits = tree.all_hits(**how)
    found = tree.gather(**how, **RULES[rule])
    added = contributions(lines, hits, RULES[rule], spread=spread)
    assert len(hits) > 500
    assert np.array_equal(found.count, np.bincount(hits.ray[added[:, 0] != 0], minlength=200))
    for name, expected in (("sum", added), ("squares", added**2)):
        of_rays = np.zeros((200, added.shape[1]))
        np.add.at(of_rays, hits.ray, expected)
        if (got := getattr(found, name)) is not None:
            scale = np.zeros_like(of_rays)
            np.add.at(scale, hits.ray, np.abs(expected))
            assert (np.abs(got.reshape(of_rays.shape) - of_rays) <= 2e-5 * scale + 1e-12).all(), name
    assert (found.squares is not None) == RULES[rule].get("squares", False)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("method", METHODS)
def test_every_tree_sums_to_the_same_bits(method: str, rule: str) -> None:
    lines = THICK if rule == "beams" else fl.Lines.from_segments(SEGMENTS)
    how = {**RAYS, "radius": 0.05, **RULES[rule]}
    assert_same(build(lines, method=method).gather(**how), fl.brute_force_gather(lines, **how))


def test_kernels_threads_and_instruction_sets_sum_to_the_same_bits() -> None:
    tree = build(THICK)
    for rule in RULES.values():
        for spread in (0.0, 0.02):
            how = {**RAYS, "radius": 0.05, "spread": spread, **rule}
            expected = fl.brute_force_gather(THICK, **how)
            for kernel, n_threads in itertools.product(("auto", "single", "wave", "bundle", "binary"), (1, 3)):
                with num_threads(n_threads):
                    assert_same(tree.gather(**how, kernel=kernel), expected)
    for simd in fl.available_simd():
        fl.set_simd(simd)
        assert_same(tree.gather(**how), expected)


@pytest.mark.parametrize("kind", ALL_KINDS)
def test_every_kind_is_the_same_as_brute_force(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_lists, "COUNTED_RAYS", 7)
    monkeypatch.setattr(gather, "LIST_BYTES", 1 << 12)
    made = ALL_KINDS[kind](SEGMENTS)
    tree = build(made)
    values = RNG.random(len(tree.geometry))
    how = {**RAYS, "radius": 0.05, "values": values}
    if not any(part.has_directions for part in tree.geometry.each_part()):
        how["blur"] = "none"
    found = tree.gather(**how)
    assert found.count.sum() > 50
    assert_same(found, fl.brute_force_gather(made, **how))
    hits = tree.all_hits(**RAYS, radius=0.05)
    counted = tree.gather(**RAYS, radius=0.05, values=values, blur="none", inner=False)
    expected = np.bincount(hits.ray, values.astype(np.float32)[hits.prim_number], minlength=200)
    assert np.array_equal(counted.count, hits.counts)
    assert np.allclose(counted.sum, expected, rtol=1e-12)


def test_lines_of_a_geometry_are_those_alone() -> None:
    both = fl.build(fl.Geometry([THICK, fl.Triangles(RNG.random((9, 3, 3)))]))
    how = {**RAYS, "radius": 0.02, "line_sigma": 2, "phase": 0.3}
    found, expected = both.gather(**how, parts=0), build(THICK).gather(**how)
    assert np.array_equal(found.count, expected.count)
    assert np.allclose(found.sum, expected.sum, rtol=1e-5)


def test_ignored_lines_add_nothing() -> None:
    tree, ignored = build(THICK), np.arange(0, 300, 2)
    values = np.where(np.isin(np.arange(300), ignored), 0, 1)
    left = tree.gather(**RAYS, radius=0.02, ignore=ignored)
    assert np.allclose(left.sum, tree.gather(**RAYS, radius=0.02, values=values).sum, rtol=1e-6)


def test_a_forest_sums_to_the_same_bits(tmp_path: Any) -> None:
    lines = forests.strands(radius=RNG.random((330, 1))[:, 0] * 0.02)
    fl.build_forest(lines, tmp_path / "forest", max_segments=50)
    forest, tree = fl.Forest(tmp_path / "forest"), fl.build(lines)
    assert forest.n_tiles > 3
    how = {**RAYS, "radius": 0.05, "values": RNG.random((300, 2)), "sigma": 0.3, "line_sigma": 1, "squares": True}
    assert_same(forest.gather(**how), tree.gather(**how))
    assert_same(forest.on(map).gather(**how, kernel="wave"), tree.gather(**how))
    tree.save(tmp_path / "tree.flt")
    assert_same(fl.Forest(tmp_path / "tree.flt").gather(**how), tree.gather(**how))


def test_sums_do_not_depend_on_how_lines_are_cut() -> None:
    ends = np.round(SEGMENTS * 2**12) / 2**12  # so that float32 holds the ends of pieces
    cut = ends[:, :1] + np.linspace(0, 1, 65)[:, None] * (ends[:, 1:] - ends[:, :1])  # (300, 65, 3)
    pieces = np.stack([cut[:, :-1], cut[:, 1:]], axis=2).reshape(-1, 2, 3)
    how = {**RAYS, "radius": 0.02, "sigma": 2.0}
    whole, parts = build(ends).gather(**how), build(pieces).gather(**how)
    assert (whole.count > 0).sum() > 100
    differ = np.abs(parts.sum - whole.sum) > 1e-5 * whole.sum
    assert differ.sum() <= 2, "only hits that rounding moves across an end or the radius may differ"
    # With their ends, pieces add more: each end cap of a capsule does.
    with_ends = build(pieces).gather(**how, inner=False)
    assert with_ends.sum.sum() > 1.2 * parts.sum.sum()


def test_a_box_blur_keeps_the_length_of_lines() -> None:
    # Parallel rays on a grid of pitch h: the sum of K / sin θ over all of them is length / h².
    tree = fl.build([[[-0.4, -0.3, 0], [0.35, 0.42, 0.5]], [[0.1, 0.4, 0.2], [0.1, -0.4, 0.2]]])
    h = 1 / 256
    x, y = np.meshgrid(np.arange(-1, 1, h), np.arange(-1, 1, h))
    origins = np.stack([x, y, np.full_like(x, -5)], axis=-1)
    length = tree.geometry.lengths().sum()
    for blur in ("box", "epanechnikov"):
        found = tree.gather(origins, [0, 0, 2], 16 * h, blur=blur).sum.sum() * h * h
        assert found == pytest.approx(length, rel=2e-3)


def test_parallel_lines_are_left_out() -> None:
    tree = fl.build([[[0.1, 0, 0], [0.1, 0, 5]], [[0.1, 0, 1], [0.1001, 0, 5]]])
    found = tree.gather([0, 0, -1], [0, 0, 1], 0.2, inner=False)
    assert found.count == 1
    assert tree.gather([0, 0, -1], [0, 0, 1], 0.2, blur="none", inner=False).count == 2


def test_depths_are_read_in_any_range_of_t() -> None:
    tree, table = fl.build([[[-1, 0, 0], [1, 0, 0]]]), np.linspace(0, 1, 1000)[None]
    rays = [[0, 0, 0]], [[0, 0, 1]], 0.5
    # The hit is at t = 0. The first range is a number below the least normal one, the second more than float32 holds.
    for bounds, share in (((0, 1e-40), 0), ((-1e-40, 0), 1), ((0, 0), 0), ((-3e38, 3e38), 0.5), ((-3e38, 1e38), 0.75)):
        how: dict[str, Any] = {"t_min": bounds[0], "t_max": bounds[1], "optical_depth": table, "inner": False}
        assert tree.gather(*rays, **how).sum == pytest.approx([np.exp(-share)], rel=1e-6), bounds
        assert tree.gather(*rays, **how, kernel="binary").sum == tree.gather(*rays, **how).sum


def test_the_least_reach_adds_what_float32_holds() -> None:
    tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
    rays = [[0, 0, -1]], [[0, 0, 1]]
    assert tree.gather(*rays, 1e-37).sum == pytest.approx([5e36])
    for values in (None, [0.0]):
        found = tree.gather(*rays, 1e-44, values=values, inner=False)
        assert found.sum == found.count == 0
    assert tree.gather(*rays, 1e-10, [1e38], sigma=200).sum == 0, "light that is absorbed, however much it was"


def test_large_and_small_contributions() -> None:
    lines = np.stack([[-1, 0, z, 1, 0, z] for z in range(64)]).reshape(-1, 2, 3)
    values = np.float32(2.0) ** np.repeat(np.arange(-10, 22), 2)
    tree = fl.build(lines)
    assert tree.gather([0, 0, -1], [0, 0, 1], 0.1, values, blur="none").sum == values.astype(np.float64).sum()
    signed = tree.gather([0, 0, -1], [0, 0, 1], 0.1, np.r_[values[:32], -values[:32]], blur="none", squares=True)
    assert signed.sum == 0
    assert signed.squares == 2 * (values[:32].astype(np.float64) ** 2).sum()
    huge = tree.gather([0, 0, -1], [0, 0, 1], 1e-3, np.full(64, 3e38))
    assert huge.sum == np.inf


def test_shapes_follow_rays_and_channels() -> None:
    tree = fl.build(SEGMENTS)
    rays = ORIGINS[:12].reshape(3, 4, 3), [0, 0, 1], 0.1
    assert tree.gather(*rays).sum.shape == (3, 4)
    assert tree.gather(*rays, VALUES[:, :1]).sum.shape == (3, 4, 1)
    found = tree.gather(*rays, VALUES, squares=True)
    assert found.sum.shape == found.squares.shape == (3, 4, 3)  # type: ignore[union-attr]
    assert found.count.shape == (3, 4)
    assert tree.gather(*rays, VALUES[:, 0], sigma=[1, 2]).sum.shape == (3, 4, 2)
    assert np.array_equal(tree.gather(*rays, VALUES[:, 1]).sum, found.sum[..., 1])
    assert tree.gather(np.zeros((0, 3)), [0, 0, 1], 0.1).sum.shape == (0,)
    assert tree.gather(np.zeros((5, 3)), [0, 0, 1], 0.1, t_max=0).count.tolist() == [0] * 5
    assert fl.build(np.zeros((0, 2, 3))).gather(*rays, np.zeros(0)).sum.tolist() == np.zeros((3, 4)).tolist()
    assert "12 rays" in repr(found)


def test_skipped_rays_sum_to_nothing() -> None:
    origins = np.array([[0.5, 0.5, -1], [np.nan, 0, 0]])
    found = fl.build(SEGMENTS).gather(origins, [0, 0, 1], 0.2, invalid="skip")
    assert found.count[0] > 0
    assert found.sum[1] == 0
    assert found.skipped.tolist() == [1]
    depths = np.array([[0, 1], [np.nan, np.nan]])
    how: dict[str, Any] = {"t_max": [2, np.inf], "invalid": "skip"}
    found = fl.build(SEGMENTS).gather(origins, [0, 0, 1], 0.2, optical_depth=depths, **how)
    assert found.sum[0] > 0
    assert found.sum[1] == 0
    assert np.isnan(depths[1]).all(), "the array is the caller's"


def test_progress_is_reported() -> None:
    seen: list[float] = []
    fl.build(SEGMENTS).gather(**RAYS, radius=0.05, progress=seen.append)
    fl.brute_force_gather(SEGMENTS, **RAYS, radius=0.05, progress=seen.append)
    assert seen[-1] == 1.0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"values": np.ones(5)}, "values have shape (5,); expected (300,)"),
        ({"values": np.full(300, np.nan)}, "values hold NaN"),
        ({"values": np.full(300, 1e39)}, "what float32 cannot hold"),
        ({"values": np.ones((300, 9))}, "9 channels are more than one call sums, 8"),
        ({"values": VALUES, "sigma": [1, 2]}, "values has 3, sigma has 2 channels"),
        ({"sigma": -1}, "sigma=-1; expected numbers from 0 up"),
        ({"line_sigma": np.inf}, "line_sigma=inf"),
        ({"sigma": np.ones((2, 2))}, "sigma has shape (2, 2)"),
        ({"phase": 1}, "phase=1; expected a number between -1 and 1"),
        ({"phase": "forward"}, "phase='forward'"),
        ({"blur": "gauss"}, "blur='gauss' is not a choice"),
        ({"radius": 0}, "radius=0 leaves a blur no width"),
        ({"optical_depth": np.ones(5)}, "optical_depth has shape (5,); expected (200, K)"),
        ({"optical_depth": np.ones((199, 3))}, "optical_depth has shape (199, 3); expected (200, K)"),
        ({"optical_depth": np.ones((200, 1))}, "K ≥ 2"),
        ({"optical_depth": np.full((200, 3), -1)}, "numbers below 0"),
        ({"optical_depth": np.ones((200, 3)), "sigma": 1}, "pass one of them"),
        ({"optical_depth": np.ones((200, 3, 2)), "sigma": [0, 1]}, "pass one of them"),
        ({"optical_depth": np.ones((200, 3)), "t_max": np.inf}, "pass finite t_min= and t_max="),
    ],
)
def test_bad_input_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(fl.InputError) as error:
        fl.build(SEGMENTS).gather(**{**RAYS, "radius": 0.05, **given})
    assert message in str(error.value)


def test_what_has_no_directions_is_refused() -> None:
    triangles = fl.build(fl.Triangles(RNG.random((9, 3, 3))))
    with pytest.raises(fl.InputError, match="needs the directions of lines, and the tree is over 9 triangles"):
        triangles.gather(ORIGINS, DIRECTIONS)
    with pytest.raises(fl.InputError, match=r"phase=0\.5 needs the directions"):
        triangles.gather(ORIGINS, DIRECTIONS, blur="none", phase=0.5)
    assert triangles.gather(ORIGINS, DIRECTIONS, blur="none").count.sum() > 0
    balls = fl.Spheres.from_centres(RNG.random((9, 3)), radius=0.5)
    mixed = fl.build(fl.Geometry([fl.Lines.from_segments(SEGMENTS), balls, THICK]))
    assert mixed.gather(ORIGINS, DIRECTIONS, 0).count.sum() > 0, "some of the lines are thick"
    with pytest.raises(fl.InputError, match="radius=0 leaves a blur no width"):
        mixed.gather(ORIGINS, DIRECTIONS, 0, parts=[0, 1])
    curves = fl.build(ALL_KINDS["curves"](SEGMENTS))
    with pytest.raises(fl.InputError, match="line_sigma is for straight lines"):
        curves.gather(ORIGINS, DIRECTIONS, line_sigma=1)
