"""The command line: one clear sentence for every bad file, argument and ray."""

from __future__ import annotations

import gzip
import json
import os
import re
import struct
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from support.command_line import done, refused, run
from support.slow import few_of

import fastlines as fl

pytestmark = pytest.mark.usefixtures("in_own_folder")


def hair(n_points=4, said=4):
    return struct.pack("<4s4I5f88s", b"HAIR", 1, said, 2, said - 1, 0, 0, 0, 0, 0, b"") + bytes(12 * n_points)


def tfx(strands, vertices, n_points):
    return struct.pack("<f7I128x", 4.0, strands, vertices, 160, 0, 0, 0, 0) + bytes(16 * n_points)


def trk():
    data = resources.files("nibabel") / "tests" / "data" / "standard.trk"
    return data.read_bytes()


def npy(*values):
    np.save("x.npy", np.array(values))
    return Path("x.npy").read_bytes()


BAD_FILES = {
    "empty.npy": lambda: b"",
    "text.npy": lambda: b"hello",
    "shape.npy": lambda: npy(1.0, 2.0),
    "nan.npy": lambda: npy([[0, 0, 0], [0, np.nan, 1]]),
    "inf.npy": lambda: npy([[0, 0, 0], [0, np.inf, 1]]),
    "words.npy": lambda: npy("a", "b"),
    "cut.npy": lambda: npy(*np.zeros((9, 2, 3)))[:-1],
    "lying.npy": lambda: npy(*np.zeros((9, 2, 3))).replace(b"(9, 2, 3)", b"(99999999999, 2, 3)"),
    "cut.npz": lambda: b"PK\3\4 not a zip",
    "cut.hair": lambda: hair()[:-1],
    "lying.hair": lambda: hair(4, 2**31),
    "other.hair": lambda: b"HAIR",
    "cut.tfx": lambda: tfx(2, 3, 6)[:-1],
    "lying.tfx": lambda: tfx(2**31, 2**31, 6),
    "version.tfx": lambda: b"\0\0\x40\x40" * 100,
    "cut.trk": lambda: trk()[:-1],
    "lying.trk": lambda: trk()[:988] + struct.pack("<i", 999) + trk()[992:],
    "text.tck": lambda: b"mrtrix tracks\nEND\n",
    "cut.tfx.gz": lambda: gzip.compress(tfx(2, 3, 6))[:-1],
    "cut.flt": lambda: Path("s.flt").read_bytes()[:-1],
    "long.flt": lambda: Path("s.flt").read_bytes() + b"\0",
    "text.flt": lambda: b"hello, I am a tree",
    "empty.flt": lambda: b"",
    "lying.flt": lambda: Path("s.flt").read_bytes().replace(b'"shape": [60', b'"shape": [61'),
    "torn.flt": lambda: Path("s.flt").read_bytes()[:-2000] + bytes(2000),
    "unknown.xyz": lambda: b"1 2 3",
    "none": lambda: b"1 2 3",
}


@pytest.mark.parametrize("name", few_of(BAD_FILES, n=8))
@pytest.mark.parametrize("command", ["info", "build", "render", "validate", "query", "nearest", "pairs"])
def test_bad_files(tree_file, name, command):
    with open(name, "wb") as file:
        file.write(BAD_FILES[name]())
    if command == "info" and name in ("nan.npy", "inf.npy"):  # which are counted
        assert json.loads(run("info", name, "--json").stdout)["lines"]["n_skipped"] == 1
        return
    options = {"render": ("-r", 0.1, "-o", "a.png"), "query": ("--camera", "8x8", "-r", 0.1), "nearest": ("1,2,3",)}
    options |= {"pairs": ("-r", 0.1)}
    _, sentence = refused(command, name, *options.get(command, ()))
    assert name in sentence
    assert not os.path.exists("a.png")


def test_an_empty_array_can_be_looked_at_but_not_built():
    np.save("empty.npy", np.empty((0, 2, 3)))
    assert json.loads(done("info", "empty.npy", "--json"))["lines"]["bounds"] is None
    done("info", "empty.npy")
    assert "holds no segments" in refused("build", "empty.npy", "-o", "empty.flt")[1]
    fl.build(np.empty((0, 2, 3))).save("empty.flt")
    done("validate", "empty.flt")
    assert "holds no segments" in refused("render", "empty.flt", "-r", 1, "-o", "empty.png")[1]
    done("query", "empty.flt", "--camera", "4x4", "-r", 1, "-k", "all")


@pytest.mark.parametrize(
    ("args", "code", "words"),
    [
        (("info", "missing.tfx"), 1, "missing.tfx: no such file"),
        (("info", "missing"), 1, "missing: no such file"),
        (("info", "missing.xyz"), 1, "missing.xyz: no such file"),
        (("info", "missing.flt.gz"), 1, "missing.flt.gz: no such file"),
        (("validate", "missing.flt"), 1, "missing.flt"),
        (("info", "spaghetti"), 1, "scene:spaghetti"),
        (("info", "."), 1, "directory"),
        (("validate", "folder.flt"), 1, "directory"),
        (("info", "folder.tfx"), 1, "directory"),
        (("build", "scene:spagetti"), 1, "did you mean 'spaghetti'"),
        (("build", "scene:spaghetti:many"), 1, "scene:NAME:SEGMENTS"),
        (("build", "scene:spaghetti:1:2:3"), 1, "scene:NAME:SEGMENTS"),
        (("build", "scene:spaghetti:0"), 1, "n_segments=0; expected a whole number, 1 to 100000000"),
        (("build", "scene:spaghetti:100000000000000000000000"), 1, "n_segments=1"),
        (("build", "scene:spaghetti:" + "9" * 5000), 1, "scene:NAME:SEGMENTS"),
        (("build", "scene:spaghetti:-5"), 1, "scene:NAME:SEGMENTS"),
        (("build", "scene:spaghetti", "-m", "bvhd2"), 1, "did you mean 'bvh-d2'"),
        (("build", "scene:spaghetti", "-o", "tree.txt"), 1, ".flt"),
        (("build", "scene:spaghetti", "-o", "no/tree.flt"), 1, "there is no folder no"),
        (("build", "scene:spaghetti", "-o", "folder.flt"), 1, "is a directory"),
        (("build", "scene:spaghetti", "--c-trav", "0"), 1, "c_trav"),
        (("build", "scene:spaghetti", "--c-trav", "nan"), 1, "c_trav"),
        (("build", "scene:spaghetti", "--max-refs", "3"), 1, "max_refs"),
        (("build", "scene:spaghetti", "--max-bytes", "3000"), 1, "allow 480000 or more"),
        (("build", "scene:spaghetti", "--max-bytes", "4 apples"), 1, "'4 apples' is not an amount of memory"),
        (("build", "scene:spaghetti", "--max-bytes", "nan"), 1, "'nan' is not an amount of memory"),
        (("build", "scene:spaghetti", "--max-bytes", "1gmb"), 1, "'1gmb' is not an amount of memory"),
        (("build", "scene:spaghetti", "--max-bytes", "-1GB"), 1, "max_bytes=-1000000000"),
        (("build", "scene:spaghetti", "--max-depth", "-3"), 1, "max_depth"),
        (("build", "scene:spaghetti", "--max-depth", "x"), 2, "--max-depth"),
        (("scene", "spagetti"), 1, "did you mean"),
        (("scene", "spaghetti", "-n", "0"), 1, "n_segments=0"),
        (("scene", "spaghetti", "-n", "x"), 2, "'-n'"),
        (("scene", "spaghetti", "--seed", "-1"), 1, "seed"),
        (("scene", "spaghetti", "-o", "a.tfx"), 1, ".npz"),
        (("scene", "spaghetti", "-o", "no/a.npz"), 1, "there is no folder"),
        (("validate", "s.png"), 1, "expected a tree file"),
        (("render", "s.flt", "-r", "-1", "-o", "a.png"), 2, "-1.0"),
        (("render", "s.flt", "-r", "nan", "-o", "a.png"), 2, "nan"),
        (("render", "s.flt", "-r", "inf", "-o", "a.png"), 2, "inf"),
        (("render", "s.flt", "-r", "1e300", "-o", "a.png"), 1, "radius"),
        (("render", "s.flt", "-r", "abc", "-o", "a.png"), 2, "--radius"),
        (("render", "s.flt", "-o", "a.png", "--look", "hairs"), 1, "did you mean 'hair'"),
        (("render", "s.flt", "-o", "a.png", "--color", "blue"), 1, "no attribute 'blue'"),
        (("render", "s.flt", "-o", "a.png", "--color", "#12"), 1, "six hexadecimal digits"),
        (("render", "s.flt", "-o", "a.png", "--background", "pink"), 1, "'pink' is not a colour"),
        (("render", "s.flt", "-o", "a.png", "--levels", "2", "--look", "tube"), 1, "--look does not apply"),
        (("render", "s.flt", "-r", "1"), 2, "--output"),
        (("render", "s.flt", "-r", "1", "-o", "a.jpg"), 1, "known: .png, .exr"),
        (("render", "s.flt", "-r", "1", "-o", "a"), 1, "known: .png, .exr"),
        (("render", "s.flt", "-r", "1", "-o", "no/a.png"), 1, "there is no folder no"),
        (("render", "s.flt", "-r", "1", "-o", "folder.png"), 1, "is a directory"),
        (("render", "s.flt", "-r", "1", "-o", "a.exr", "--levels", "2"), 1, ".png"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--width", "0"), 2, "--width"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--height", "-3"), 2, "--height"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--width", "1000000000"), 1, "1000000000"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--width", "9" * 30), 1, "expected a whole number, 1 to"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--samples", "0"), 2, "--samples"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--fov", "180"), 1, "180"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--fov", "nan"), 1, "nan"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--direction", "0,0"), 1, "three numbers"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--direction", "0,0,0"), 1, "direction"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--up", "0,nan,0"), 1, "finite"),
        (("query", "s.flt", "-r", "1"), 1, "--camera"),
        (("query", "s.flt", "rays.npy", "--camera", "4x4", "-r", "1"), 1, "--camera"),
        (("query", "s.flt", "missing.npy", "-r", "1"), 1, "missing.npy"),
        (("query", "s.flt", "rays.txt", "-r", "1"), 1, "(n, 6)"),
        (("query", "s.flt", "--camera", "4", "-r", "1"), 1, "640x480"),
        (("query", "s.flt", "--camera", "0x4", "-r", "1"), 1, "width=0"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "-k", "best"), 1, "first, any, all, next, count"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "-k", "next"), 1, "--nearest"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "--nearest", "2"), 1, "--kind next"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "-k", "next", "--nearest", "-2"), 1, "k=-2"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "--at", "end"), 1, "at='end'"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "--t-min", "2", "--t-max", "1"), 1, "t_min"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "-o", "a.txt"), 1, ".npz"),
        # What does not apply is not ignored.
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "-k", "any", "--rank", "t"), 1, "--rank does not apply"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "-k", "count", "--merge", "strand"), 1, "--kind count"),
        (
            ("query", "s.flt", "rays.npy", "-r", "1", "--direction", "1,2,3", "--fov", "77"),
            1,
            "--direction and --fov do",
        ),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "-m", "kd-cl"), 1, "--method does not apply"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--levels", "2", "--width", "50"), 1, "--width does not apply"),
        (("render", "s.flt", "-o", "a.png", "--look", "hits", "--color", "strand"), 1, "--color does not apply"),
        (
            ("render", "s.flt", "-o", "a.png", "--look", "tube", "--quality", "high"),
            1,
            "--quality does not apply",
        ),
        (("render", "s.flt", "-o", "a.exr", "--background", "transparent"), 1, "always transparent"),
        (("build", "scene:spaghetti", "--c-trav", "1e308"), 1, "1e-100 to 1e100"),
        (("demo", "-o", "s.flt"), 1, "s.flt"),
        (("demo", "-o", "s.flt/x"), 1, "s.flt"),
        (("report", "s.flt", "-o", "s.flt"), 1, "s.flt"),
        (("frobnicate",), 2, "frobnicate"),
        (("validate",), 2, "TREE"),
        (("info", "s.flt", "--frob"), 2, "--frob"),
        (("info", "a\nb.tfx"), 1, "no such file"),
    ],
)
def test_bad_arguments(tree_file, args, code, words):
    for name in ("folder.flt", "folder.tfx", "folder.png"):
        os.mkdir(name)
    got, sentence = refused(*args)
    assert got == code
    assert words in sentence


@pytest.mark.parametrize(
    ("rays", "words"),
    [
        (np.zeros((3, 5)), "(n, 6)"),
        (np.zeros(6), "(n, 6)"),
        (np.full((3, 6), np.nan), "3 of 3 rays"),
        (np.zeros((3, 6)), "length zero"),
        (np.array([["a"] * 6]), "numbers"),
    ],
)
def test_bad_rays(tree_file, rays, words):
    np.save("rays.npy", rays)
    assert words in refused("query", tree_file, "rays.npy", "-r", 1)[1]


def test_bad_ray_files(tree_file):
    np.save("whole.npy", np.ones((50, 6)))
    data = Path("whole.npy").read_bytes()
    for name, content in {
        "cut.npy": data[:-8],
        "text.npy": b"hello",
        "empty.npy": b"",
        "lying.npy": data.replace(b"(50, 6)", b"(5000000000, 6)"),
        "cut.npz": b"PK\3\4",
        "pickle.npy": data.replace(b"'<f8'", b"'|O' "),
    }.items():
        with open(name, "wb") as file:
            file.write(content)
        assert name in refused("query", tree_file, name, "-r", 1)[1]
    np.savez("other.npz", origins=np.zeros((1, 3)))
    assert "directions" in refused("query", tree_file, "other.npz", "-r", 1)[1]


def test_an_invalid_tree_names_node_and_axiom(tree_file):
    tree = fl.build(fl.load(tree_file).geometry, "bvh-cl")
    nodes = tree.nodes.copy()
    nodes["box"][1:] = nodes["box"][0]  # loose, which loses no hit
    fl.Tree(tree.geometry, nodes, tree.refs, tree.settings).save("bad.flt")
    assert re.search(r"node \d+ breaks", refused("validate", "bad.flt")[1])
