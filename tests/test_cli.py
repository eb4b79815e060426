"""The command line: what each command does, and one clear sentence for everything that can go wrong."""

from __future__ import annotations

import gzip
import json
import os
import re
import signal
import struct
import subprocess
import sys
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import fastlines as fl
from fastlines.cli import app
from fastlines.cli.app import explain
from fastlines.cli.info import count_duplicates

COMMANDS = ("demo", "scene", "info", "build", "validate", "query", "render")


@pytest.fixture(autouse=True)
def in_own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("FASTLINES_DEBUG", raising=False)


def run(*args):
    return CliRunner().invoke(app, [str(arg) for arg in args])


def done(*args):
    """Run a command that works; return what it prints."""
    result = run(*args)
    assert (result.exit_code, result.stderr) == (0, "")
    return result.stdout


def refused(*args):
    """Run a command that does not work; return its exit code and its one sentence."""
    result = run(*args)
    assert result.exit_code not in (0, 70), result.output
    assert result.stdout == ""
    assert re.fullmatch(r"error: [^\n]+\n", result.stderr), result.stderr
    assert "Traceback" not in result.stderr
    assert not list(os.scandir(".")) or not [entry for entry in os.scandir(".") if entry.name.endswith(".partial")]
    return result.exit_code, result.stderr


@pytest.fixture
def tree_file(tmp_path):
    fl.build(fl.scenes.make("spaghetti", 60).lines, "kd-d2").save(tmp_path / "s.flt")
    return "s.flt"


# --- What works ---


def test_help_is_pleasant():
    text = done("--help")
    assert done() == text
    for command in COMMANDS:
        assert command in text
        shown = done(command, "-h")
        assert "Examples" in shown
        assert f"fastlines {command}" in shown
    assert fl.__version__ in done("--version")


def test_scene_info_build_validate_render(tmp_path):
    assert "bun-hair" in done("scene")
    assert "300 segments" in done("scene", "bun-hair", "-n", 300, "--seed", 5, "-o", "hair.npz")
    lines = fl.read("hair.npz")
    expected = fl.scenes.make("bun-hair", 300, 5).lines
    assert (lines.segments == expected.segments).all()
    assert (lines.strands == expected.strands).all()

    told = json.loads(done("info", "hair.npz", "--json"))["lines"]
    assert (told["n_segments"], told["n_strands"], told["n_zero_length"]) == (300, 6, 0)
    assert "300" in done("info", "hair.npz")

    assert "cost" in done("build", "hair.npz", "--method", "bvh-cl", "-o", "hair.flt")
    tree = fl.load("hair.flt")
    assert tree.method == "bvh-cl"
    assert "valid" in done("validate", "hair.flt")
    assert json.loads(done("validate", "hair.flt", "--json"))["valid"]
    assert json.loads(done("info", "hair.flt", "--json"))["tree"]["n_nodes"] == tree.n_nodes

    for source in ("hair.flt", "hair.npz", "scene:bun-hair:300:5"):
        done("render", source, "--radius", 0.01, "-o", "hair.png", "--width", 40, "--height", 30)
        picture = np.asarray(Image.open("hair.png"))
        assert picture.shape == (30, 40)
        assert picture.max() > 200
    done("render", "hair.flt", "-r", 0.01, "-o", "levels.png", "--levels", 2)
    assert np.asarray(Image.open("levels.png")).shape[2] == 3
    assert sorted(path.name for path in tmp_path.iterdir()) == ["hair.flt", "hair.npz", "hair.png", "levels.png"]


def test_render_looks_where_it_is_told(tree_file):
    options = ("-r", 0.01, "--width", 24, "--height", 24, "--samples", 1)
    pictures = []
    for look in (("0,0,-1", "0,1,0"), ("0,-1,0", "0,0,1")):
        done("render", tree_file, *options, "--direction", look[0], "--up", look[1], "--fov", 20, "-o", "a.png")
        pictures.append(np.asarray(Image.open("a.png")))
    assert (pictures[0] != pictures[1]).any()


def test_render_exr(tree_file):
    openexr = pytest.importorskip("OpenEXR")
    done("render", tree_file, "-r", 0.02, "-o", "a.exr", "--width", 20, "--height", 10)
    with openexr.File("a.exr") as file:
        depth = file.channels()["Z"].pixels
    assert depth.shape == (10, 20)
    assert np.isfinite(depth).any()


def test_build_takes_costs_and_limits():
    text = done("build", "scene:spaghetti:50", "-m", "bvh-cl", "--c-trav", 1.5, "--max-depth", 1, "--json")
    stats = json.loads(text)
    assert stats["depth"] <= 1
    assert stats["method"] == "custom"
    text = done("build", "scene:spaghetti:500", "-m", "bvh-cl", "--max-depth", 1, "-o", "a.flt")
    assert re.search(r"max_depth kept \d nodes from a split", text)
    assert "max_depth at" in done("info", "a.flt")


def test_info_counts_what_is_odd():
    segments = np.zeros((5, 2, 3), np.float32)
    segments[1:, 1] = (1, 2, 3)
    segments[3] = segments[3, ::-1]  # the same, the other way round
    segments[4, 1] = (1, 2, 4)
    np.save("a.npy", segments)
    told = json.loads(done("info", "a.npy", "--json"))["lines"]
    assert (told["n_zero_length"], told["n_duplicates"], told["n_strands"]) == (1, 2, 0)
    assert told["bounds"] == [[0, 0, 0], [1, 2, 4]]
    empty = fl.Lines.from_segments([])
    assert count_duplicates(empty) == 0
    segments[2] = np.nan
    np.save("b.npy", segments)
    result = run("info", "b.npy", "--json", "--skip-invalid")
    assert json.loads(result.stdout)["lines"]["n_skipped"] == 1
    assert "1 segments" in result.stderr


def test_query_answers_as_the_library_does(tree_file):
    tree = fl.load(tree_file)
    rng = np.random.default_rng(3)
    rays = np.concatenate([rng.random((50, 3)), rng.normal(size=(50, 3))], axis=1).astype(np.float32)
    np.save("rays.npy", rays)
    np.savez("rays.npz", origins=rays[:, :3], directions=rays[:, 3:])
    for name in ("rays.npy", "rays.npz"):
        for kind, arrays in {
            "first": ["distance", "prim", "t", "u"],
            "all": ["distance", "offsets", "prim", "t", "u"],
            "any": ["hit"],
            "count": ["count"],
        }.items():
            done("query", tree_file, name, "-r", 0.1, "--kind", kind, "-o", "out.npz")
            with np.load("out.npz") as out:
                assert sorted(out.files) == arrays
                answers = dict(out)
            method = {"first": "first_hit", "all": "all_hits", "any": "any_hit", "count": "count_hits"}[kind]
            expected = getattr(tree, method)(rays[:, :3], rays[:, 3:], 0.1)
            for array in arrays:
                assert (answers[array] == (getattr(expected, array) if kind in ("first", "all") else expected)).all()
    done("query", tree_file, "rays.npy", "-r", 0.1, "--at", "surface", "-o", "out.npz")
    with np.load("out.npz") as out:
        assert "t_out" in out.files
    told = json.loads(done("query", tree_file, "rays.npy", "-r", 0.1, "-k", "count", "--json", "--t-max", 0.5))
    assert told["n_rays"] == 50
    assert told["n_hits"] == tree.count_hits(rays[:, :3], rays[:, 3:], 0.1, t_max=0.5).sum()
    assert "192 rays" in done("query", tree_file, "--camera", "16x12", "-r", 0.1)


# --- What does not ---


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


@pytest.mark.parametrize("name", BAD_FILES)
@pytest.mark.parametrize("command", ["info", "build", "render", "validate", "query"])
def test_bad_files(tree_file, name, command):
    with open(name, "wb") as file:
        file.write(BAD_FILES[name]())
    options = {"render": ("-r", 0.1, "-o", "a.png"), "query": ("--camera", "8x8", "-r", 0.1)}
    _, sentence = refused(command, name, *options.get(command, ()))
    assert name in sentence
    assert not os.path.exists("a.png")


def test_an_empty_array_is_no_lines_but_no_crash():
    np.save("empty.npy", np.empty((0, 2, 3)))
    assert json.loads(done("info", "empty.npy", "--json"))["lines"]["bounds"] is None
    done("info", "empty.npy")
    done("build", "empty.npy", "-o", "empty.flt")
    done("validate", "empty.flt")
    done("render", "empty.flt", "-r", 1, "-o", "empty.png", "--width", 8, "--height", 8)
    done("query", "empty.flt", "--camera", "4x4", "-r", 1, "-k", "all")


@pytest.mark.parametrize(
    ("args", "code", "words"),
    [
        (("info", "missing.tfx"), 1, "missing.tfx: no such file"),
        (("validate", "missing.flt"), 1, "missing.flt"),
        (("info", "spaghetti"), 1, "scene:spaghetti"),
        (("info", "."), 1, "directory"),
        (("validate", "folder.flt"), 1, "directory"),
        (("info", "folder.tfx"), 1, "directory"),
        (("build", "scene:spagetti"), 1, "did you mean 'spaghetti'"),
        (("build", "scene:spaghetti:many"), 1, "scene:NAME:SEGMENTS"),
        (("build", "scene:spaghetti:1:2:3"), 1, "scene:NAME:SEGMENTS"),
        (("build", "scene:spaghetti:0"), 1, "at least 1"),
        (("build", "scene:spaghetti:-5"), 1, "scene:NAME:SEGMENTS"),
        (("build", "scene:spaghetti", "-m", "bvhd2"), 1, "did you mean 'bvh-d2'"),
        (("build", "scene:spaghetti", "-o", "tree.txt"), 1, ".flt"),
        (("build", "scene:spaghetti", "-o", "no/tree.flt"), 1, "there is no folder no"),
        (("build", "scene:spaghetti", "-o", "folder.flt"), 1, "is a directory"),
        (("build", "scene:spaghetti", "--c-trav", "0"), 1, "c_trav"),
        (("build", "scene:spaghetti", "--c-trav", "nan"), 1, "c_trav"),
        (("build", "scene:spaghetti", "--max-refs", "3"), 1, "max_refs"),
        (("build", "scene:spaghetti", "--max-depth", "-3"), 1, "max_depth"),
        (("build", "scene:spaghetti", "--max-depth", "x"), 2, "--max-depth"),
        (("scene", "spagetti"), 1, "did you mean"),
        (("scene", "spaghetti", "-n", "0"), 1, "at least 1"),
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
        (("render", "s.flt", "-o", "a.png"), 2, "--radius"),
        (("render", "s.flt", "-r", "1"), 2, "--output"),
        (("render", "s.flt", "-r", "1", "-o", "a.jpg"), 1, "known: .png, .exr"),
        (("render", "s.flt", "-r", "1", "-o", "a"), 1, "known: .png, .exr"),
        (("render", "s.flt", "-r", "1", "-o", "no/a.png"), 1, "there is no folder no"),
        (("render", "s.flt", "-r", "1", "-o", "folder.png"), 1, "is a directory"),
        (("render", "s.flt", "-r", "1", "-o", "a.exr", "--levels", "2"), 1, ".png"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--width", "0"), 2, "--width"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--height", "-3"), 2, "--height"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--width", "1000000000"), 1, "1000000000"),
        (("render", "s.flt", "-r", "1", "-o", "a.png", "--width", "9" * 30), 1, "smaller"),
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
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "-k", "best"), 1, "first, any, all, count"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "--at", "end"), 1, "at='end'"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "--t-min", "2", "--t-max", "1"), 1, "t_min"),
        (("query", "s.flt", "--camera", "4x4", "-r", "1", "-o", "a.txt"), 1, ".npz"),
        (("demo", "-o", "s.flt"), 1, "s.flt"),
        (("demo", "-o", "s.flt/x"), 1, "s.flt"),
        (("frobnicate",), 2, "frobnicate"),
        (("info",), 2, "INPUT"),
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
    tree = fl.load(tree_file)
    nodes = tree.nodes.copy()
    leaf = int(np.flatnonzero(tree.is_leaf)[0])
    nodes["box"][leaf, 1] = nodes["box"][leaf, 0]
    fl.Tree(tree.geometry, nodes, tree.refs, tree.settings).save("bad.flt")
    assert re.search(r"node \d+ breaks", refused("validate", "bad.flt")[1])


# --- Everything else that can happen ---


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (KeyboardInterrupt(), 130, "stopped"),
        (MemoryError(), 1, "memory"),
        (OSError(28, "No space left on device", "a.png"), 1, "a.png: No space left on device"),
        (PermissionError(13, "Permission denied", "a.png"), 1, "a.png: Permission denied"),
        (OSError("odd"), 1, "odd"),
        (ZeroDivisionError("x"), 70, "bug in fastlines"),
        (fl.FileFormatError("two\nlines"), 1, "two lines"),
    ],
)
def test_errors_become_sentences(error, code, words, monkeypatch):
    assert explain(error) == (code, explain(error)[1])
    assert words in explain(error)[1]

    def fail(*_, **__):
        raise error

    monkeypatch.setattr(fl.scenes, "make", fail)
    result = run("build", "scene:spaghetti")
    assert result.exit_code == code
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


def program(code, *args):
    """Start the command line in a process of its own, which runs some code first."""
    command = [sys.executable, "-c", f"from fastlines.cli import main\n{code}\nmain()", *args]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_ctrl_c_stops_a_build():
    listen = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); print('on', flush=True)"
    process = program(listen, "build", "scene:spaghetti-2:100000", "-m", "kd-d2")
    assert process.stdout.readline() == "on\n"
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(1)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (130, "", "stopped\n")


def test_nobody_reads_the_output():
    process = program("", "scene")
    process.stdout.close()
    err = process.stderr.read()
    process.wait(30)
    process.stderr.close()
    assert (process.returncode, err) == (141, "")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a full disk")
def test_the_disk_is_full():
    with open("/dev/full", "w") as full:
        process = subprocess.run(
            [sys.executable, "-c", "from fastlines.cli import main; main()", "scene"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert (process.returncode, process.stderr) == (1, "error: No space left on device\n")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_can_not_be_written_to(tree_file):
    os.mkdir("locked", 0o500)
    assert "locked" in refused("render", tree_file, "-r", 1, "-o", "locked/a.png")[1]
    assert "locked" in refused("demo", "-o", "locked/demo")[1]
