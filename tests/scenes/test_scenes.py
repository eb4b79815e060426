"""The thesis's scenes: as many segments as asked for, the same each time, and shaped as they should be."""

import numpy as np
import pytest

from fastlines import scenes
from fastlines.errors import InputError
from fastlines.scenes import beams, bun_hair, straight_hair

SIZES = {
    "bun-hair": 82_250,
    "straight-hair": 87_460,
    "spaghetti": 2_000,
    "spaghetti-2": 8_000,
    "photon-beams": 36_294,
}


@pytest.fixture(scope="module")
def default():
    return {name: scenes.make(name) for name in scenes.NAMES}


def joints(lines):
    """Rows of the segments that go on where the row before them, of the same strand, ended."""
    return 1 + np.flatnonzero(lines.strands[1:] == lines.strands[:-1])


def lengths(lines):
    return np.linalg.norm(np.diff(lines.segments.astype(float), axis=1)[:, 0], axis=1)


def test_names_and_radii():
    assert list(scenes.NAMES) == list(SIZES)
    assert scenes.RADII == {"W": 0.005, "M": 0.001, "N": 0.0005}


@pytest.mark.parametrize("name", SIZES)
def test_default_size_place_and_frame(default, name):
    scene = default[name]
    lines = scene.lines
    assert len(lines) == SIZES[name]
    assert (lines.bounds >= -0.01).all()
    assert (lines.bounds <= 1.01).all()
    assert np.ptp(lines.bounds, axis=0).max() > 0.85  # about the unit cube
    assert (np.unique(lines.strands) == np.arange(lines.n_strands)).all()
    assert (np.diff(lines.strands) >= 0).all()
    assert (lengths(lines) > 0).all()

    pixels, depth = scene.camera.project(lines.segments.reshape(-1, 3), 1000, 1000)
    assert (depth > 0).all()
    assert np.allclose([np.ptp(pixels, axis=0).max(), pixels.min(), pixels.max()], [950, 25, 975], atol=0.1)


@pytest.mark.parametrize("name", SIZES)
@pytest.mark.parametrize("n_segments", [1, 7, 1001])
def test_small_scenes_are_the_beginning_of_the_whole(default, name, n_segments):
    scene = scenes.make(name, n_segments)
    whole = default[name].lines
    assert len(scene.lines) == n_segments
    assert (scene.lines.segments == whole.segments[:n_segments]).all()
    assert (scene.lines.strands == whole.strands[:n_segments]).all()
    pixels, _ = scene.camera.project(scene.lines.segments.reshape(-1, 3), 64, 64)
    assert pixels.min() > 0
    assert pixels.max() < 64


@pytest.mark.parametrize("name", SIZES)
def test_same_seed_same_bits(name):
    first, again, other = (scenes.make(name, 500, seed).lines for seed in (3, np.int64(3), 4))
    assert first.segments.tobytes() == again.segments.tobytes()
    assert (first.segments != other.segments).any()


def test_each_scene_has_its_own_numbers(default):
    assert (default["spaghetti"].lines.segments != default["spaghetti-2"].lines.segments[:2000]).any(axis=(1, 2)).all()


@pytest.mark.parametrize("name", ["spaghetti", "spaghetti-2"])
def test_spaghetti_joins_opposite_faces(default, name):
    segments = default[name].lines.segments
    across = (segments[:, 0] == 0) & (segments[:, 1] == 1)
    assert (across.sum(axis=1) == 1).all()
    assert np.allclose(across.mean(axis=0), 1 / 3, atol=0.04)
    free = segments[~np.repeat(across[:, None], 2, axis=1)]
    assert np.allclose(np.histogram(free, 4, (0, 1))[0] / len(free), 0.25, atol=0.02)


@pytest.mark.parametrize(("name", "module"), [("bun-hair", bun_hair), ("straight-hair", straight_hair)])
def test_hair_is_whole_and_outside_the_head(default, name, module):
    lines = default[name].lines
    assert (np.bincount(lines.strands) == module.N_PER_STRAND).all()
    rows = joints(lines)
    assert (lines.segments[rows, 0] == lines.segments[rows - 1, 1]).all()

    along = np.linspace(0, 1, 9)[:, None, None]
    points = (1 - along) * lines.segments[:, 0] + along * lines.segments[:, 1]
    depth = np.linalg.norm((points - module.HEAD.centre) / module.HEAD.radii, axis=-1)
    assert depth.min() > 0.99
    roots = lines.segments[:: module.N_PER_STRAND, 0]
    assert np.linalg.norm((roots - module.HEAD.centre) / module.HEAD.radii, axis=-1).max() < 1.02


def test_straight_hair_falls_straight(default):
    lines = default["straight-hair"].lines
    tips = lines.segments[straight_hair.N_PER_STRAND - 1 :: straight_hair.N_PER_STRAND]
    assert tips[:, 1, 1].max() < 0.15  # all reach the level of the ends
    slope = (tips[:, 0, 1] - tips[:, 1, 1]) / np.linalg.norm(tips[:, 0] - tips[:, 1], axis=1)
    assert slope.min() > 0.9
    assert lengths(lines).mean() > lengths(default["bun-hair"].lines).mean()


def test_bun_hair_is_wound(default):
    segments = default["bun-hair"].lines.segments.reshape(-1, bun_hair.N_PER_STRAND, 2, 3)
    axis = bun_hair.TIE / bun_hair.HEAD.radii
    axis /= np.linalg.norm(axis)
    across = np.array([1.0, 0.0, 0.0])
    from_tie = segments[:, :, 1] - bun_hair.HEAD.at(bun_hair.TIE)
    turn = np.unwrap(np.arctan2(from_tie @ np.cross(axis, across), from_tie @ across), axis=1) / (2 * np.pi)
    # The last half of a strand lies in the bun, but for the few strays.
    near = np.linalg.norm(from_tie[:, 25:], axis=2).max(axis=1) < 0.2
    assert 0.93 < near.mean() < 0.99
    assert np.median(turn[near, -1] - turn[near, 20]) > 1.5


def test_beams_start_at_the_light_and_go_on(default):
    lines = default["photon-beams"].lines
    rows = joints(lines)
    assert (lines.segments[rows, 0] == lines.segments[rows - 1, 1]).all()
    starts = np.setdiff1d(np.arange(len(lines)), rows)
    assert (lines.segments[starts, 0] == np.float32(beams.LIGHT)).all()
    assert np.allclose(directions(lines)[starts].mean(axis=0), 0, atol=0.05)  # isotropic


def directions(lines):
    offsets = np.diff(lines.segments.astype(float), axis=1)[:, 0]
    return offsets / np.linalg.norm(offsets, axis=1, keepdims=True)


def test_beams_mirror_at_the_walls_and_scatter_inside(default):
    lines = default["photon-beams"].lines
    # Directions of very short segments are lost in float32.
    long = lengths(lines) > 0.01
    rows = joints(lines)
    rows = rows[long[rows] & long[rows - 1]]
    joint = lines.segments[rows, 0]
    walls = (joint == 0) | (joint == 1)
    before, after = directions(lines)[rows - 1], directions(lines)[rows]
    mirrored = walls.any(axis=1)
    assert (walls.sum(axis=1) <= 1).all()
    assert np.allclose(np.where(walls, -before, before)[mirrored], after[mirrored], atol=1e-4)

    # Henyey–Greenstein: the mean cosine is g, and the mean of the second Legendre polynomial g².
    cosine = (before * after).sum(axis=1)[~mirrored]
    assert len(cosine) > 8000
    assert np.isclose(cosine.mean(), beams.G, atol=0.02)
    assert np.isclose((1.5 * cosine**2 - 0.5).mean(), beams.G**2, atol=0.02)


def test_beams_free_path_and_albedo():
    lines = scenes.make("photon-beams", 100_000, seed=1).lines
    complete = lines.strands < lines.strands[-1]
    length = lengths(lines)[complete]
    end = lines.segments[complete, 1]
    events = (~((end == 0) | (end == 1)).any(axis=1)).sum()
    # Every free path ends in an event; a photon sees 1 / (1 − albedo) of them.
    assert np.isclose(length.sum() / events, 1 / beams.EXTINCTION, rtol=0.02)
    assert np.isclose(events / lines.strands[-1], 1 / (1 - beams.ALBEDO), rtol=0.04)
    # A line through a cube is 4V/A long on average, and light that fills it evenly meets walls as often.
    assert np.isclose(length.sum() / (complete.sum() - events), 2 / 3, rtol=0.05)


def test_beams_do_not_depend_on_the_batch():
    results = [beams.generate(3000, np.random.default_rng(5), batch=batch) for batch in (1, 7, 4096)]
    for lines in results[1:]:
        assert lines.segments.tobytes() == results[0].segments.tobytes()
        assert (lines.strands == results[0].strands).all()


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("spagheti", "did you mean 'spaghetti'"),
        ("Bun Hair", "'bun-hair'"),
        (3, "known: bun-hair"),
        (["a"], "known: bun-hair"),
    ],
)
def test_unknown_scene(name, hint):
    with pytest.raises(InputError, match=hint) as error:
        scenes.make(name)
    assert all(known in str(error.value) for known in scenes.NAMES)


@pytest.mark.parametrize("n_segments", [0, -1, 2.5, True, "9"])
def test_sizes_that_can_not_be(n_segments):
    with pytest.raises(InputError, match=f"n_segments={n_segments!r}"):
        scenes.make("spaghetti", n_segments)


@pytest.mark.parametrize("seed", [-1, 0.5, None])
def test_seeds_that_can_not_be(seed):
    with pytest.raises(InputError, match="seed="):
        scenes.make("spaghetti", 5, seed)
