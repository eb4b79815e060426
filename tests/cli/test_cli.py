"""The command line: what each command does, and how it ends when something outside stops it."""

from __future__ import annotations

import itertools
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support.command_line import done, refused, run
from support.patience import HANGS

import fastlines as fl
from fastlines.cli.app import explain
from fastlines.cli.query import KINDS
from fastlines.support.texts import bytes_text

COMMANDS = (
    "demo",
    "scene",
    "info",
    "convert",
    "build",
    "validate",
    "query",
    "nearest",
    "within",
    "pairs",
    "render",
    "beams",
    "report",
)

pytestmark = pytest.mark.usefixtures("in_own_folder")

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


def test_the_package_runs_as_a_module():
    ran = subprocess.run([sys.executable, "-m", "fastlines", "--version"], capture_output=True, text=True, check=True)
    assert ran.stdout == f"fastlines {fl.__version__}\n"
    ran = subprocess.run([sys.executable, "-m", "fastlines", "info", "no.tfx"], capture_output=True, text=True)
    assert (ran.returncode, ran.stderr[:20]) == (1, "error: no.tfx: no su")


@pytest.mark.parametrize(
    ("n_bytes", "expected"),
    [(48, "48 bytes"), (1000, "1.0 kB"), (999_949, "999.9 kB"), (999_950, "1.0 MB"), (10**9, "1,000.0 MB")],
)
def test_sizes(n_bytes, expected):
    assert bytes_text(n_bytes) == expected


def test_scene_info_build_validate_render(tmp_path):
    assert "bun-hair" in done("scene")
    assert "300 segments" in done("scene", "bun-hair", "-n", 300, "--seed", 5, "-o", "hair.npz")
    lines = fl.read("hair.npz")
    expected = fl.scenes.make("bun-hair", 300, 5).lines
    assert (lines.segments == expected.segments).all()
    assert (lines.strands == expected.strands).all()

    told = json.loads(done("info", "hair.npz", "--json"))["lines"]
    assert (told["n_segments"], told["n_strands"], told["n_zero_length"]) == (300, 6, 0)
    assert "9.6 kB" in done("info", "hair.npz")  # 300 times 24 bytes of a segment and 8 of its strand

    assert "cost" in done("build", "hair.npz", "--method", "bvh-cl", "-o", "hair.flt")
    tree = fl.load("hair.flt")
    assert tree.method == "bvh-cl"
    assert "valid" in done("validate", "hair.flt")
    assert json.loads(done("validate", "hair.flt", "--json"))["valid"]
    assert json.loads(done("info", "hair.flt", "--json"))["tree"]["n_nodes"] == tree.n_nodes

    for source in ("hair.flt", "hair.npz", "scene:bun-hair:300:5"):
        done("render", source, "--radius", 0.01, "-o", "hair.png", "--width", 40, "--height", 30)
        picture = np.asarray(Image.open("hair.png"))
        assert picture.shape == (30, 40, 3)
        assert np.ptp(picture) > 100
    done("render", "hair.flt", "-r", 0.01, "-o", "levels.png", "--levels", 2)
    assert np.asarray(Image.open("levels.png")).shape[2] == 3
    assert sorted(path.name for path in tmp_path.iterdir()) == ["hair.flt", "hair.npz", "hair.png", "levels.png"]


def test_build_takes_costs_and_limits():
    text = done("build", "scene:spaghetti:50", "-m", "bvh-cl", "--c-trav", 1.5, "--max-depth", 1, "--json")
    stats = json.loads(text)
    assert stats["depth"] <= 1
    assert stats["method"] == "custom"
    text = done("build", "scene:spaghetti:500", "-m", "bvh-cl", "--max-depth", 1, "-o", "a.flt")
    assert re.search(r"max_depth kept \d nodes from a split", text)
    assert "max_depth kept" in done("info", "a.flt")
    freely, *kept = (
        json.loads(done("build", "scene:spaghetti:5000", "--json", *more))
        for more in ((), *(("--max-bytes", size) for size in (7_000_000, "7e6", "7MB", "7000k", "6.67572 MiB")))
    )
    assert freely["n_refs"] > 77_500 > kept[0]["n_refs"]  # 7 MB less 160 bytes a segment, at 80 a reference
    assert {tree["n_refs"] for tree in kept} == {kept[0]["n_refs"]}
    text = done("build", "scene:spaghetti:500", "-m", "bvh-cl", "--max-leaf-refs", 4)
    assert re.search(r"; max_leaf_refs forced \d+ splits\n", text)


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
    assert empty.count_repeats() == 0
    segments[2] = np.nan
    np.save("b.npy", segments)
    result = run("info", "b.npy", "--json")
    assert json.loads(result.stdout)["lines"]["n_skipped"] == 1
    assert "1 segment with NaN or Inf was left out" in result.stderr


def test_query_answers_as_the_library_does(tree_file):
    tree = fl.load(tree_file)
    rng = np.random.default_rng(3)
    rays = np.concatenate([rng.random((50, 3)), rng.normal(size=(50, 3))], axis=1).astype(np.float32)
    np.save("rays.npy", rays)
    np.savez("rays.npz", origins=rays[:, :3], directions=rays[:, 3:])
    for name in ("rays.npy", "rays.npz"):
        for kind, arrays in {
            "first": ["distance", "prim", "strand", "t", "u"],
            "all": ["distance", "offsets", "prim", "strand", "t", "u"],
            "next": ["distance", "offsets", "prim", "strand", "t", "u"],
            "any": ["hit"],
            "count": ["count"],
        }.items():
            more = {"next": {"k": 2}}.get(kind, {})
            done(
                "query",
                tree_file,
                name,
                "-r",
                0.1,
                "--kind",
                kind,
                *(("--nearest", 2) if more else ()),
                "-o",
                "out.npz",
            )
            with np.load("out.npz") as out:
                assert sorted(out.files) == arrays
                answers = dict(out)
            expected = getattr(tree, KINDS[kind])(rays[:, :3], rays[:, 3:], 0.1, **more)
            for array in arrays:
                assert (answers[array] == (expected if kind in ("any", "count") else getattr(expected, array))).all()
    done("query", tree_file, "rays.npy", "-r", 0.1, "--at", "surface", "-o", "out.npz")
    with np.load("out.npz") as out:
        assert "t_out" in out.files
    told = json.loads(done("query", tree_file, "rays.npy", "-r", 0.1, "-k", "count", "--json", "--t-max", 0.5))
    assert told["n_rays"] == 50
    assert told["n_hits"] == tree.count_hits(rays[:, :3], rays[:, 3:], 0.1, t_max=0.5).sum()
    assert "192 rays" in done("query", tree_file, "--camera", "16x12", "-r", 0.1)


def test_query_tells_the_rows_of_what_was_not_skipped():
    ends = np.array([[[0, 0, 0], [1, 0, 0]], [[0, 0, np.nan], [1, 0, 1]], [[0, 1, 0], [1, 1, 0]]])
    fl.build(ends, invalid="skip").save("skipped.flt")
    np.save("rays.npy", np.array([[0.5, y, -1, 0, 0, 1] for y in (0, 1, 9)], np.float32))
    for kind, rows in {"first": [0, 2, -1], "all": [0, 2]}.items():
        done("query", "skipped.flt", "rays.npy", "-r", 0.1, "-k", kind, "-o", "out.npz")
        with np.load("out.npz") as out:
            assert out["row"].tolist() == rows


def test_query_tells_strands_where_there_are_any():
    fl.build(fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0]], [[0, 1, 0], [1, 1, 0]]])).save("strands.flt")
    np.save("rays.npy", np.array([[0.5, y, -1, 0, 0, 1] for y in (0, 1, 9)], np.float32))
    for kind, strands in {"first": [0, 1, -1], "all": [0, 1]}.items():
        done("query", "strands.flt", "rays.npy", "-r", 0.1, "-k", kind, "-o", "out.npz")
        with np.load("out.npz") as out:
            assert out["strand"].tolist() == strands


# --- Everything else that can happen ---


def test_help_keeps_its_brackets():
    assert "offsets[i] to offsets[i + 1]" in " ".join(done("query", "--help").split())


def test_input_is_not_written_over(tree_file):
    np.savez("rays.npz", origins=np.zeros((1, 3)), directions=np.ones((1, 3)))
    before = Path("rays.npz").read_bytes()
    _, said = refused("query", tree_file, "rays.npz", "--radius", "0.1", "-o", "./rays.npz")
    assert "rays.npz: is read from; write to another file" in said
    assert Path("rays.npz").read_bytes() == before


def test_an_empty_name_and_pickled_rays(tree_file):
    assert "the name of a file is empty" in refused("info", "")[1]
    np.save("objects.npy", np.array([{}, None], object), allow_pickle=True)
    assert "holds Python objects, not numbers" in refused("query", tree_file, "objects.npy", "--radius", "0.1")[1]


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


def test_packed_trees_are_refused_with_the_reason():
    Path("hair.flt.gz").write_bytes(b"packed")
    assert "trees are not compressed" in refused("info", "hair.flt.gz")[1]


def program(code, *args):
    """Start the command line in a process of its own, which runs some code first."""
    command = [sys.executable, "-c", f"from fastlines.cli import main\n{code}\nmain()", *args]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_ctrl_c_stops_a_build():
    # A build that would take hours says when it is under way.
    listen = """
import signal
import fastlines as fl
signal.signal(signal.SIGINT, signal.default_int_handler)
build = fl.build
def say(share):
    if not shares:
        print("on", flush=True)
    shares.append(share)
shares = []
fl.build = lambda lines, *args, **given: build(lines, lookahead=8, progress=say)
"""
    with program(listen, "build", "scene:spaghetti-2:20000") as process:
        try:
            assert process.stdout.readline() == "on\n"
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=HANGS)
        finally:
            process.kill()
    assert (process.returncode, out, err) == (130, "", "stopped\n")


def test_nobody_reads_the_output():
    process = program("", "scene")
    process.stdout.close()
    err = process.stderr.read()
    process.wait(HANGS)
    process.stderr.close()
    assert (process.returncode, err) == (141, "")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a full disk")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_the_disk_is_full(unbuffered):
    with open("/dev/full", "w") as full:
        process = subprocess.run(
            [sys.executable, "-c", "from fastlines.cli import main; main()", "scene"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
        )
    assert (process.returncode, process.stderr) == (1, "error: No space left on device\n")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_can_not_be_written_to(tree_file):
    os.mkdir("locked", 0o500)
    assert "locked" in refused("render", tree_file, "-r", 1, "-o", "locked/a.png")[1]
    assert "locked" in refused("demo", "-o", "locked/demo")[1]


@pytest.mark.parametrize("kind", ["triangles", "curves", "both"])
def test_commands_take_trees_over_other_shapes(kind: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    triangles = fl.Triangles((rng.random((30, 1, 3)) + 0.1 * rng.normal(size=(30, 3, 3))).astype(np.float32))
    curves = fl.Curves.from_bezier(rng.random((9, 4, 3)), 0.02)
    geometry = {"triangles": triangles, "curves": curves, "both": fl.Geometry([triangles, curves])}[kind]
    fl.build(geometry).save(tmp_path / "a.flt")
    source = str(tmp_path / "a.flt")
    told = done("info", source)
    assert (" 30\n" in told) == (kind != "curves")
    facts = json.loads(done("info", source, "--json"))["shapes"]
    assert facts.get("n_curves") == (9 if kind != "triangles" else None)
    assert "valid" in done("validate", source)
    done("render", source, "-o", str(tmp_path / "a.png"), "--width", "40", "--height", "40")
    done("query", source, "--camera", "20x20", "--kind", "all", "-o", str(tmp_path / "hits.npz"))
    with np.load(tmp_path / "hits.npz") as hits:
        assert ("part" in hits) == (kind == "both")
        assert len(hits["prim"]) > 0


def test_info_without_a_file_describes_the_installation():
    said = done("info")
    assert said.splitlines()[0].startswith(f"fastlines {fl.__version__}, Python 3.")
    assert f"instruction set  {fl.simd()}\n" in said
    assert fl.simd() in json.loads(done("info", "--json"))["compiled"]
    assert "there is no INPUT" in refused("info", "--picture")[1]


def test_a_mistyped_command_has_a_suggestion():
    assert "'render'" in refused("rendr")[1]


@pytest.mark.parametrize("columns", [80, 100, 130])
@pytest.mark.parametrize("command", COMMANDS)
def test_help_fills_the_width_of_the_terminal(command, columns, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    lines = done(command, "--help").splitlines()
    assert max(map(len, lines)) <= columns
    # A line of the description ends where the next word has no place, or at the end of a paragraph.
    described = [line.strip() for line in lines]
    end = next(i for i, line in enumerate(described) if re.search("(Arguments|Options)( |:)", line))
    for line, following in itertools.pairwise(described[:end]):
        if line and following:
            assert len(line) + 1 + len(following.split()[0]) > columns - 6, line


def test_help_names_whole_options(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = done("render", "--help")
    assert "--focus-distance D" in text
    assert "'#rrggbb:#rrggbb' from top" in text


def test_a_dry_run_says_what_a_build_takes() -> None:
    source = "scene:spaghetti:20000"
    facts = json.loads(done("build", source, "--dry-run", "--json"))
    tree = json.loads(done("build", source, "--json"))
    assert facts["n_prims"] == tree["n_prims"] == 20_000
    assert facts["n_refs"] == pytest.approx(tree["n_refs"], rel=0.2)
    assert facts["tree_bytes"] == pytest.approx(tree["memory_bytes"], rel=0.3)
    assert facts["build_peak_bytes"] > facts["tree_bytes"]
    told = done("build", source, "--dry-run", "--method", "bvh-cl", "--output", "none.flt")
    assert "20,000 references" in told
    assert "a tile of a forest" in told
    assert not Path("none.flt").exists()
    assert facts["seconds"] > 0
    by_model = json.loads(done("info", source, "--json"))["build"]
    assert by_model["build_peak_bytes"] > by_model["tree_bytes"] > 0
