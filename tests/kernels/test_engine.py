"""The wide engine: every instruction set and kernel answers as brute force does, whatever the rays are like."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same, options
from support.slow import few_of

import fastlines as fl
from fastlines import engines
from fastlines.query.backend import KERNELS
from fastlines.query.queries import QUERIES

WIDE = [kernel for kernel in KERNELS if kernel != "binary"]


@pytest.fixture(autouse=True)
def any_simd() -> Iterator[None]:
    yield
    fl.set_simd(None)


def pictures(n: int) -> dict[str, tuple[Any, Any]]:
    """Rays as pictures have them: from far, from inside, shuffled, of another aspect."""
    size = (3 * n, n)
    from_far = fl.Camera((0.5, 0.4, 4.0), (0.5, 0.5, 0.5), fov_degrees=20.0).rays(*size)
    inside = fl.Camera((0.5, 0.5, 0.5), (0.1, 0.9, 0.2), fov_degrees=80.0).rays(*size)
    order = np.random.default_rng(n).permutation(3 * n * n)
    return {"from far": from_far, "from inside": inside, "shuffled": (from_far[0][order], from_far[1][order])}


@pytest.mark.parametrize("scene", few_of(fl.scenes.NAMES, n=1))
@pytest.mark.parametrize("rays", few_of(["from far", "from inside", "shuffled"]))
def test_pictures_of_scenes(scene: str, rays: str) -> None:
    lines = fl.scenes.make(scene, 400).lines
    tree = fl.build(lines)
    asked = pictures(43)[rays]  # no whole number of tiles, and a last row of tiles that is cut
    for radius in (0.0, 0.002, 0.05):
        for query in QUERIES:
            expected = fl.brute_force(lines, *asked, radius, query=query, **options(query))
            for kernel in WIDE:
                assert_same(getattr(tree, query)(*asked, radius, **options(query), kernel=kernel), expected)


@pytest.mark.parametrize("left_out", [(0, 0), (13, 0), (0, 29), (50, 67)])
def test_pictures_that_begin_or_end_in_a_row(left_out: tuple[int, int]) -> None:
    """Any part of a picture is a batch like others: its last row may be short, or its first."""
    lines = fl.scenes.make("bun-hair", 300).lines
    tree = fl.build(lines)
    o, d = fl.scenes.make("bun-hair", 300).camera.rays(64, 41)
    part = slice(left_out[0], len(o) - left_out[1])
    for query in QUERIES:
        expected = fl.brute_force(lines, o[part], d[part], 0.01, query=query, **options(query))
        assert_same(getattr(tree, query)(o[part], d[part], 0.01, **options(query)), expected)


@pytest.mark.parametrize("scale", few_of([1e-6, 1.0, 1e6], n=1))
@pytest.mark.parametrize("shift", [0.0, 1e4])
def test_scaled_and_moved_scenes(scale: float, shift: float) -> None:
    lines = ((fl.scenes.make("photon-beams", 300).lines.segments.astype(float) + shift) * scale).astype(np.float32)
    tree = fl.build(lines)
    o, d = pictures(40)["from far"]
    o = ((o.astype(float) + shift) * scale).astype(np.float32)
    for radius in (0.0005 * scale, 0.005 * scale, 3 * scale):
        for query in ("first_hit", "all_hits", "any_hit"):
            expected = fl.brute_force(lines, o, d, radius, query=query)
            for kernel in WIDE:
                assert_same(getattr(tree, query)(o, d, radius, kernel=kernel), expected)


@pytest.mark.parametrize("method", ["bvh-ss", "kd-d2"])
def test_large_leaves_are_laid_out(method: str) -> None:
    """Spaghetti is one leaf of 500 to some builders; a block holds 16."""
    lines = fl.scenes.make("spaghetti", 500).lines
    tree = fl.build(lines, method)
    assert len(np.unique(tree.layout.refs[:, 0])) == 500
    rays = pictures(30)["from far"]
    for query in QUERIES:
        expected = fl.brute_force(lines, *rays, 0.01, query=query, **options(query))
        assert_same(getattr(tree, query)(*rays, 0.01, **options(query)), expected)


def tiled(tree: fl.Tree) -> int:
    """How many pieces of the layout are empty, of which those of each segment are to tile it."""
    prim, both = tree.layout.refs.T
    first, last = both & 0xFFFF, both >> 16
    order = np.lexsort((last, first, prim))
    prim, first, last = prim[order], first[order], last[order]
    new = np.diff(prim) > 0
    assert new.sum() == len(tree.geometry) - 1
    assert (first[1:] == np.where(new, 0, last[:-1])).all()
    assert (last[:-1][new] == 0xFFFF).all()
    assert (first[0], last[-1]) == (0, 0xFFFF)
    return int((first == last).sum())


def test_pieces_tile_their_segments() -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 300).lines)
    assert tree.n_refs > 1000
    assert tiled(tree) == 0


@pytest.mark.slow
@pytest.mark.parametrize("end", [1e4, 0.0])
def test_lines_cut_more_finely_than_references_tell(end: float) -> None:
    """Lines ten thousand times as long as a thicket are cut within it, into less than 1/65536 of them."""
    rng = np.random.default_rng(5)
    thicket = rng.uniform(-1, 1, (4000, 1, 3)) + rng.normal(0, 0.1, (4000, 2, 3))
    along = rng.normal(size=(30, 1, 3)) * [[[-2e4], [end]]]
    segments = np.concatenate([thicket, rng.uniform(-0.5, 0.5, (30, 1, 3)) + along]).astype(np.float32)
    tree = fl.build(segments, "kd-cl")
    assert tiled(tree) > 100
    origins, directions = rng.uniform(-1, 1, (2000, 3)), rng.normal(size=(2000, 3))
    hits = fl.brute_force(segments, origins, directions, 0.02, query="all_hits")
    assert (hits.prim >= 4000).sum() > 20
    for query in QUERIES:
        expected = fl.brute_force(segments, origins, directions, 0.02, query=query, **options(query))
        for kernel in WIDE:
            assert_same(getattr(tree, query)(origins, directions, 0.02, kernel=kernel, **options(query)), expected)


@pytest.mark.parametrize("n_refs", [0, 1, 16, 17, 40])
def test_small_layouts_by_several_threads(n_refs: int) -> None:
    """A root that is a leaf, of none, of as many as a block holds, and of more."""
    segments = np.random.default_rng(0).uniform(-1, 1, (n_refs, 2, 3)).astype(np.float32)
    fl.set_num_threads(3)
    try:
        tree = fl.build(segments, limits=fl.Limits(max_depth=0), method="bvh-cl")
        assert tree.n_nodes == 1
        assert len(tree.layout.refs) == n_refs
        rays = np.random.default_rng(1).normal(size=(2, 300, 3))
        expected = fl.brute_force(segments, *rays, 0.1, query="count_hits")
        assert tree.count_hits(*rays, 0.1).tolist() == expected.tolist()
    finally:
        fl.set_num_threads(None)


def test_layout_is_small() -> None:
    lines = fl.scenes.make("spaghetti").lines
    layout = fl.build(lines).layout
    assert layout.n_bytes < 1.3e6
    assert layout.nodes.shape[1] == layout.leaves.shape[1] == 128
    assert layout.nodes.ctypes.data % 128 == layout.leaves.ctypes.data % 128 == 0
    assert not layout.nodes.flags.writeable


def test_wrong_names() -> None:
    tree = fl.build([[[0, 0, 0], [1, 1, 1]]])
    with pytest.raises(fl.InputError, match="kernel='fast' is not a choice"):
        tree.first_hit([0, 0, -5], [0, 0, 1], 0.1, kernel="fast")
    with pytest.raises(fl.InputError, match="simd='mmx' is not available here; expected one of"):
        fl.set_simd("mmx")
    program = "import fastlines as fl; print(fl.simd())"
    for name in fl.available_simd():
        said = subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "FASTLINES_SIMD": name},
            text=True,
            capture_output=True,
            check=True,
        )
        assert said.stdout.strip() == name
    said = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "FASTLINES_SIMD": "mmx"},
        text=True,
        capture_output=True,
        check=False,
    )
    assert "FASTLINES_SIMD='mmx' is not available here" in said.stderr


@pytest.fixture
def build_for(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """Pretend that fastlines was built for some instruction sets, on a machine with AVX-512."""

    def pretend(*compiled: str) -> None:
        fl.available_simd.cache_clear()
        monkeypatch.setattr(engines._core, "best_simd", lambda: "avx512")
        monkeypatch.setattr(engines, "_is_compiled", compiled.__contains__)

    monkeypatch.delenv("FASTLINES_SIMD", raising=False)
    yield pretend
    monkeypatch.undo()
    fl.available_simd.cache_clear()


def test_the_default_is_the_widest_compiled_set(build_for: Callable[..., None]) -> None:
    build_for("portable", "avx2", "sse42")
    assert fl.available_simd() == ("avx2", "sse42", "portable")
    assert fl.simd() == "avx2"
    build_for("sse42", "neon")
    assert fl.simd() == "sse42"
    with pytest.raises(fl.InputError, match="simd='avx512' is not available here; expected one of sse42, neon"):
        fl.set_simd("avx512")


def test_a_build_without_a_usable_set(build_for: Callable[..., None], monkeypatch: pytest.MonkeyPatch) -> None:
    build_for()
    assert fl.available_simd() == ()
    expected = "for no instruction set, and this processor has avx512 at most: install it again on this machine, or"
    with pytest.raises(fl.FastlinesError, match=expected):
        fl.simd()
    with pytest.raises(fl.FastlinesError, match=expected):
        fl.build([[[0, 0, 0], [1, 1, 1]]])
    monkeypatch.setenv("FASTLINES_SIMD", "avx2")
    with pytest.raises(fl.FastlinesError, match=expected):
        fl.simd()


def test_the_sets_are_looked_up_once(monkeypatch: pytest.MonkeyPatch) -> None:
    tree = fl.build([[[0, 0, 0], [1, 1, 1]]])
    tree.first_hit([0, 0, -5], [0, 0, 1], 0.1)
    monkeypatch.setattr(engines.importlib.util, "find_spec", None)
    assert tree.first_hit([0, 0, -5], [0, 0, 1], 0.1).prim == 0


@pytest.mark.parametrize("simd", fl.available_simd())
def test_every_instruction_set_finds_what_can_not_be_asked(simd: str) -> None:
    tree = fl.build([[[0, 0, 0], [1, 1, 1]]])
    n = 40000  # more than are looked at in one go
    wrong = {
        "origins": (np.nan, np.inf),
        "directions": (np.nan, np.inf),
        "radius": (np.nan, -0.1, np.inf),
        "t_min": (np.nan, np.inf, 2.0),
        "t_max": (np.nan, -1.0),
    }
    fl.set_simd(simd)
    for place in (0, 17, n - 1):
        for name, values in wrong.items():
            for value in values:
                asked = {
                    "origins": np.zeros((n, 3)),
                    "directions": np.ones((n, 3)),
                    "radius": np.full(n, 0.1),
                    "t_min": np.zeros(n),
                    "t_max": np.ones(n),
                }
                asked[name].reshape(n, -1)[place, -1] = value
                with pytest.raises(ValueError, match=rf"\b{place}\b"):
                    tree.any_hit(**asked)


def hedge(n: int) -> Any:
    """Short segments across the z axis, at heights that lie the denser the lower."""
    z = np.geomspace(1e-3, 1, n)
    first = np.stack([np.full(n, -0.01), np.zeros(n), z], axis=1)
    return np.stack([first, first + np.array([0.02, 0, 0])], axis=1).astype(np.float32)


@pytest.mark.parametrize("n", [1, 8, 9, 32, 33, 90, 100, 129, 300, 500, 513, 3000])
def test_lists_are_sorted(n: int) -> None:
    """Also where t are much the same for most, the same for all, or far apart for some.

    Up to 8, 16 and 512 hits of a ray, and more, are sorted in a way of their own each, and where merged parts
    lack rows.
    """
    rng = np.random.default_rng(n)
    segments = hedge(n)[rng.permutation(n)]
    tree = fl.build(segments)
    start = rng.normal(0, 1e-4, (32, 3))
    for along, t_min, t_max in (
        ([0, 0, 1], 0, np.inf),
        ([0, 0, -1], -2, 2),
        ([0, 0, 1], 0.5, np.inf),
        ([1, 0, 0], 0, 0),
    ):
        asked: dict[str, Any] = {"t_min": t_min, "t_max": t_max, "radius": 2.0 if t_max == 0 else 0.002}
        expected = fl.brute_force(segments, start, along, **asked)
        assert len(expected) == 32 * n or t_min == 0.5
        for kernel in WIDE:
            assert_same(tree.all_hits(start, along, **asked, kernel=kernel), expected)


@pytest.mark.parametrize("jitter", few_of([0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-2], n=1))
@pytest.mark.parametrize("distance", few_of([-0.3, 0.1, 3.0, 20.0, 31.0, 1000.0], n=2))
@pytest.mark.parametrize("simd", fl.available_simd())
def test_rays_through_one_point_or_nearly(simd: str, distance: float, jitter: float) -> None:
    """Also where the point lies behind where the rays begin, within the scene or before it."""
    rng = np.random.default_rng(7)
    start = rng.uniform(-1, 1, (800, 3))
    segments = np.stack([start, start + rng.normal(0, 0.1, start.shape)], axis=1).astype(np.float32)
    tree = fl.build(segments)
    fl.set_simd(simd)
    directions = [0, 0, 1] + rng.uniform(-1, 1, (128, 3)) * [0.03, 0.03, 0]
    origins = [0.1, 0.2, -distance] + rng.normal(0, 1, directions.shape) * jitter
    for back in (0.0, 2.0):
        for radius in (0.0, 1e-3, 0.02):
            rays = origins - back * directions, directions, radius
            for query in QUERIES:
                expected = fl.brute_force(segments, *rays, query=query, **options(query))
                assert_same(getattr(tree, query)(*rays, **options(query), kernel="bundle"), expected)


@pytest.mark.parametrize("far", few_of([1.0, 1e3, 1e6, 1e9, 1e11], n=2))
@pytest.mark.parametrize("simd", fl.available_simd())
def test_rays_that_pass_far_from_the_scene(simd: str, far: float) -> None:
    """Also forced into a bundle, with a radius that just reaches the scene or does not; and leaves of one point, beside
    whose extent squares of distances may be too large.
    """
    bushes = [hedge(20), hedge(20)[:, :, [2, 0, 1]]]
    segments = np.concatenate([*bushes, [[[0, 0, 0], [0, 0, 1]]], [[[0.5, 0.5, 0.5]] * 2] * 20]).astype(np.float32)
    tree = fl.build(segments)
    fl.set_simd(simd)
    rng = np.random.default_rng(1)
    side = np.sign(rng.normal(size=(64, 1))) * far
    origins = np.concatenate([side, rng.random((64, 2))], axis=1).astype(np.float32)
    for along in ([0, 0, 1], [0, 1e-5, 1], [0, 1, 0.3]):
        for radius in (far, far * (1 - 1e-6), 0.99 * far, 1.5 * far):
            for query in QUERIES:
                expected = fl.brute_force(segments, origins, along, radius, query=query, **options(query))
                for kernel in WIDE:
                    assert_same(getattr(tree, query)(origins, along, radius, **options(query), kernel=kernel), expected)


def test_segments_whose_squares_are_nothing() -> None:
    """Squares of lengths below 1e-19 are 0, in the test from afar and in that of a leaf."""
    tiny = [[[0, 0, 0], [length, 0, 0]] for length in (0, 1e-30, 1e-25, 1e-21, 1e-19, 1e-16)]
    segments = np.array([[[-1, -1, -1]] * 2, [[1, 1, 1]] * 2, *tiny], np.float32)
    tree = fl.build(segments)
    origins = np.stack([np.linspace(0, 1e-4, 64), np.full(64, 0.1), np.full(64, -5)], axis=1).astype(np.float32)
    for radius in (0.1, 0.2, 1e6, 1e11):
        for query in QUERIES:
            expected = fl.brute_force(segments, origins, [0, 0, 1], radius, query=query, **options(query))
            for kernel in WIDE:
                assert_same(getattr(tree, query)(origins, [0, 0, 1], radius, **options(query), kernel=kernel), expected)


def test_a_ray_that_is_skipped_hides_nothing_from_its_neighbours() -> None:
    segments = np.array([[[x, 0, 0], [x, 0, 0]] for x in (-1, 0, 1)], np.float32)
    tree = fl.build(segments)
    origins = np.tile(np.array([0, 0.1, -5], np.float32), (16, 1))
    origins[3, 0] = np.nan
    for kernel in WIDE:
        hits = tree.first_hit(origins, [0, 0, 1], 0.2, invalid="skip", kernel=kernel)
        assert hits.prim.tolist() == [1] * 3 + [-1] + [1] * 12
