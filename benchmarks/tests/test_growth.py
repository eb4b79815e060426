"""The command ``growth`` at tiny sizes: its output, its fits and its errors."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_line import done, refused

import fastlines as fl
from fastlines_bench.engine.growth import run as growth
from fastlines_bench.harness import turns
from fastlines_bench.harness.rays import camera_rays, random_rays

TINY = ("--quick", "--n-rays", 1024, "--seconds", 0, "--rounds", 1)
SCENES = ("spaghetti", "bun-hair")
QUESTIONS = (("camera", "first"), ("camera", "all"), ("random", "first"), ("random", "all"))

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_run(tmp_path):
    pytest.importorskip("matplotlib")
    sizes = ("--sizes", "200,50,100,50", "--radius", 0.01)
    text = done("growth", *sizes, *TINY, "--json", "g.json", "--plot", "g.png")
    for said in ("references", "1 thread", "2 threads", "speed-up", "exponents", "0.01", *SCENES):
        assert said in text
    assert (tmp_path / "g.png").read_bytes().startswith(b"\x89PNG")

    result = json.loads((tmp_path / "g.json").read_text())
    assert result["format"] == "fastlines-bench growth 1"
    assert {"processor", "fastlines", "load"} <= result["machine"].keys()
    assert result["preset"]["sizes"] == [50, 100, 200]
    assert result["preset"]["threads"] == [1, 2]
    assert [(size["scene"], size["n_segments"]) for size in result["sizes"]] == [
        (scene, n) for scene in SCENES for n in (50, 100, 200)
    ]
    for size in result["sizes"]:
        tree = fl.build(fl.scenes.make(size["scene"], size["n_segments"]).lines)
        assert (size["n_refs"], size["bytes"]) == (len(tree.layout.refs), tree.layout.n_bytes)
        assert size["method"] == tree.method
    assert [(cell["scene"], cell["n_segments"], cell["kind"], cell["query"]) for cell in result["cells"]] == [
        (scene, n, *question) for scene in SCENES for n in (50, 100, 200) for question in QUESTIONS
    ]
    for cell in result["cells"]:
        assert cell["n_rays"] == 1024
        assert cell["hits_per_ray"] == cell["n_hits"] / 1024
        assert cell["speedup"] == cell["seconds"][0] / cell["seconds"][1]
        for mrays, ns, seconds in zip(cell["mrays"], cell["ns_per_ray"], cell["seconds"], strict=True):
            assert mrays == pytest.approx(1024 / seconds / 1e6)
            assert ns * mrays == pytest.approx(1000)
    assert [(fit["scene"], fit["kind"], fit["query"]) for fit in result["exponents"]] == [
        (scene, *question) for scene in SCENES for question in QUESTIONS
    ]
    assert all(len(fit["cost"]) == 2 for fit in result["exponents"])

    # The hits are those of the tree.
    scene = fl.scenes.make("spaghetti", 50)
    rays = camera_rays(scene.camera, 1024)
    hits = fl.build(scene.lines).all_hits(rays.origins, rays.directions, 0.01)
    assert result["cells"][1]["n_hits"] == len(hits)


def test_one_size_has_no_exponent(tmp_path):
    before = fl.get_num_threads()
    options = ("--scene", "straight-hair", "--sizes", 60, "--threads", 2, "--json", "g.json")
    text = done("growth", *options, *TINY)
    assert "An exponent needs two sizes" in " ".join(text.split())
    assert "speed-up" not in text
    assert json.loads((tmp_path / "g.json").read_text())["exponents"] == []
    assert fl.get_num_threads() == before


def test_the_fit_finds_what_was_put_in():
    sizes = [1_000, 10_000, 50_000]
    assert growth.exponent(sizes, [3 * n**0.37 for n in sizes]) == pytest.approx(0.37)
    assert growth.exponent(sizes, [7.0] * 3) == pytest.approx(0)
    # The middle one of three evenly spaced points does not change the slope of a least-squares fit.
    assert growth.exponent([1, 10, 100], [1, 99, 100]) == pytest.approx(1)

    plan = growth.GrowthPreset(scenes=("made-up",), sizes=(1_000, 10_000, 50_000), threads=(1, 4))
    cells = [
        growth.GrowthCell("made-up", n, kind, "all", 100, hits * n, (100 * n**0.5, 50 * n**0.25))
        for n in sizes
        for kind, hits in (("camera", 2), ("random", 0))
    ]
    camera, random = growth.Growth({}, plan, [], cells, 0.0).exponents()
    assert (camera.kind, random.kind) == ("camera", "random")
    assert camera.cost == pytest.approx([0.5, 0.25])
    assert camera.hits == pytest.approx(1)
    assert random.hits is None


def test_few_rays_are_spread():
    scene = fl.scenes.make("spaghetti", 50)
    picture = camera_rays(scene.camera, 64 * 64)
    few = picture.part(1500)
    assert len(few) == 6 * 256
    first = (picture.directions[:, None] == few.directions[None, ::256]).all(axis=2).argmax(axis=0)
    row, column = np.divmod(first, 64)
    window = 8 * (row // 32) + 4 * (column // 32) + row % 32 // 8  # four below each other in each quarter
    assert np.searchsorted([2, 5, 8, 10, 13], window, "right").tolist() == list(range(6))  # each from its share of 16
    assert picture.part(4096) is picture
    assert len(random_rays(scene.lines, 5000).part(4000)) == 5000
    assert len(random_rays(scene.lines, 9000).part(4000)) == 4096


def test_different_answers_raise(monkeypatch):
    monkeypatch.setattr(turns, "same", lambda a, b: False)
    with pytest.raises(RuntimeError, match="differ between 1 thread and 2 threads"):
        growth.run_growth(growth.GrowthPreset(scenes=("spaghetti",), sizes=(20,), n_rays=64, rounds=1))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--scene", "spaghetti,bunhair"], "did you mean 'bun-hair'"),
        (["--scene", ""], "--scene '' is not a scene"),
        (["--sizes", "100,x"], "--sizes 'x' is not a whole number from 1 to 100000000"),
        (["--sizes", "0"], "--sizes '0' is not a whole number"),
        (["--sizes", "100,"], "--sizes '' is not"),
        (["--sizes", "9" * 5000], "…' is not a whole number"),
        (["--threads", "1,0"], "--threads '0' is not a whole number from 1 to 1024"),
        (["--radius", "0"], "--radius 0 is not a finite number above 0"),
        (["--radius", "nan"], "--radius nan is not"),
        (["--json", "g.txt"], "expected .json"),
        (["--plot", "nowhere/g.png"], "there is no folder"),
    ],
)
def test_refused(arguments, said):
    assert said in refused("growth", *TINY, *arguments)[1]


def test_few_pixels_are_spread_over_the_picture():
    picture = camera_rays(fl.scenes.make("spaghetti", 50).camera, 512 * 512)
    few = picture.part(16 * 1024)
    assert len(few) == 16 * 1024
    rows = {ray.tobytes(): i for i, ray in enumerate(picture.directions)}
    pixels = np.array([rows[ray.tobytes()] for ray in few.directions]).reshape(-1, 8, 32)
    top, left = np.divmod(pixels[:, 0, 0], 512)
    assert (pixels == pixels[:, :1, :1] + 512 * np.arange(8)[:, None] + np.arange(32)).all()
    assert sorted(zip(top // 64, left // 64, strict=True)) == [(i, j) for i in range(8) for j in range(8)]
    assert len(few.part(2048)) == 2048


@pytest.mark.parametrize("size", [5, 15, 31, 181, 362, 1000, 1024])
def test_all_of_a_picture_is_sampled(size):
    picture = camera_rays(fl.scenes.make("spaghetti", 50).camera, size * size)
    rows = {ray.tobytes(): i for i, ray in enumerate(picture.directions)}
    windows = [picture.part(n << 10) for n in (1, 4, 16)]
    for part in windows:
        starts = {ray.tobytes() for ray in part.directions[:: part.block]}
        assert len(starts) * part.block == len(part) or len(part) == len(picture)
    where = np.array([np.divmod(rows[ray.tobytes()], size) for ray in windows[-1].directions])
    assert abs(where.mean(axis=0) / size - 0.5).max() < 0.1
    everything = picture.part(max(1, size * size - 8 * 32))
    assert {rows[ray.tobytes()] % size for ray in everything.directions} == set(range(size))
    assert len(picture.part(0)) > 0
