"""Forests on the command line: build, info, verify, and the commands that query them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.command_line import done, refused

import fastlines as fl

pytestmark = pytest.mark.usefixtures("in_own_folder")

LINES = fl.scenes.make("bun-hair", 900).lines
TREE = fl.build(LINES)


@pytest.fixture(autouse=True)
def files(in_own_folder):
    """Write lines in two files, and rays; build a forest of them."""
    fl.write("hair.npz", LINES)
    rng = np.random.default_rng(3)
    rays = np.float32(np.concatenate([rng.normal(scale=0.3, size=(50, 3)), rng.normal(size=(50, 3))], axis=1))
    np.save("rays.npy", rays)
    done("forest", "build", "hair.npz", "-o", "hair.forest", "--max-segments", 300)
    return rays[:, :3], rays[:, 3:]


def test_build_info_and_verify():
    said = json.loads(done("forest", "info", "hair.forest", "--json"))
    assert said["forest"]["n_tiles"] == len(list(Path("hair.forest").rglob("*.flt"))) > 2
    assert said["lines"]["n_segments"] == len(LINES)
    assert f"{len(LINES):,}" in done("forest", "info", "hair.forest")
    assert done("forest", "verify", "hair.forest").startswith("hair.forest: whole: ")
    assert json.loads(done("forest", "verify", "hair.forest", "--json"))["valid"] is True
    # A second build finds all of it done.
    assert "was whole, verified in" in done("forest", "build", "hair.npz", "-o", "hair.forest", "--max-segments", 300)
    next(Path("hair.forest").glob("*.flt")).unlink()
    assert ", built in" in done("forest", "build", "hair.npz", "-o", "hair.forest", "--max-segments", 300)


@pytest.mark.slow
def test_tiles_built_by_workers():
    pytest.importorskip("distributed")
    built = ("forest", "build", "hair.npz", "--max-segments", 300)
    assert "built in" in done(*built, "-o", "workers.forest", "--scheduler", "local")
    for file in Path("hair.forest").iterdir():
        assert (Path("workers.forest") / file.name).read_bytes() == file.read_bytes()


def test_a_damaged_tile_is_named():
    tile = sorted(Path("hair.forest").rglob("*.flt"))[1]
    data = bytearray(tile.read_bytes())
    data[len(data) // 2] ^= 1
    tile.write_bytes(data)
    code, text = refused("forest", "verify", "hair.forest")
    assert code == 1
    assert tile.name in text


def test_commands_ask_a_forest(files):
    done("query", "hair.forest", "rays.npy", "-r", 0.01, "-k", "all", "-o", "out.npz")
    hits = TREE.all_hits(*files, 0.01)
    with np.load("out.npz") as out:
        assert all(np.array_equal(out[name], getattr(hits, name)) for name in ("offsets", "t", "prim", "strand"))
    # The group has the same commands.
    assert done("forest", "query", "hair.forest", "rays.npy", "-r", 0.01, "--memory", "1GB").startswith(
        "hair.forest: 50"
    )
    done("nearest", "hair.forest", "0,0.1,0", "-o", "near.npz")
    with np.load("near.npz") as out:
        assert out["prim"] == TREE.nearest([0, 0.1, 0]).prim
    assert done("within", "hair.forest", "0,0.1,0", "-r", 0.2).startswith("hair.forest: 1 point, ")
    pairs = len(TREE.pairs(0.001))
    assert f"{pairs:,} pairs" in done("pairs", "hair.forest", "-r", 0.001)
    both = len(TREE.pairs(0.001, TREE))
    for first, other in (("hair.forest", "hair.npz"), ("hair.npz", "hair.forest"), ("hair.forest", "hair.forest")):
        assert f"{both:,} pairs" in done("pairs", first, "--other", other, "-r", 0.001)


def test_rays_and_hits_in_parquet(files):
    pytest.importorskip("pyarrow")
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = dict(zip(("x", "y", "z", "dx", "dy", "dz"), np.concatenate(files, axis=1).T, strict=True))
    pq.write_table(pa.table(columns), "rays.parquet")
    for source in ("hair.forest", "hair.npz"):
        assert "50 rays" in done("query", source, "rays.parquet", "-r", 0.01, "-k", "all", "-o", "hits.parquet")
        hits, table = TREE.all_hits(*files, 0.01), pq.read_table("hits.parquet")
        for name in ("ray", "t", "prim", "u", "distance", "strand"):
            assert np.array_equal(table.column(name).to_numpy(), getattr(hits, name))
    assert "go to a file" in refused("query", "hair.npz", "rays.parquet", "-r", 0.01)[1]
    assert ".parquet" in refused("query", "hair.npz", "rays.parquet", "-r", 0.01, "-o", "hits.npz")[1]


def test_a_picture_of_a_forest_is_that_of_its_tree():
    for options in ((), ("--look", "depth", "--radius", 0.01)):
        done("render", "hair.npz", "--width", 40, "--samples", 2, "-o", "tree.png", *options)
        done("forest", "render", "hair.forest", "--width", 40, "--samples", 2, "-o", "forest.png", *options)
        assert Path("forest.png").stat().st_size > 200
    assert Path("forest.png").read_bytes() == Path("tree.png").read_bytes()


def test_what_a_forest_is_not():
    assert "expected a file of lines" in refused("build", "hair.forest")[1]
    assert "expected a file of lines" in refused("info", "hair.forest")[1]
    assert "is not a forest" in refused("query", "hair.npz", "rays.npy", "-r", 0.1, "--memory", "1GB")[1]
    assert "has no levels" in refused("render", "hair.forest", "--levels", 2, "-o", "x.png")[1]
    code, text = refused("forest", "info", "hair.npz")
    assert code == 1
    assert "hair.npz" in text


def test_a_scheduler_that_is_not_there():
    pytest.importorskip("distributed")
    text = refused("query", "hair.forest", "rays.npy", "-r", 0.1, "--scheduler", "tcp://127.0.0.1:9")[1]
    assert "tcp://127.0.0.1:9" in text


def test_help():
    assert "verify" in done("forest", "--help")
    for command in ("build", "info", "verify", "query", "render", "nearest", "within", "pairs"):
        shown = done("forest", command, "-h")
        assert f"forest {command}" in shown
        assert "Examples" in shown
