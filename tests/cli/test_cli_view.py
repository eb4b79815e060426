"""``fastlines view``: a page that is served until Ctrl-C, or that is written."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest
from support.command_line import done, refused
from support.patience import HANGS

import fastlines as fl

pytest.importorskip("viser")
pytestmark = pytest.mark.usefixtures("in_own_folder")

SCENE = "scene:spaghetti:100"
#: The command line, where Ctrl-C works even if the tests run in the background.
PROGRAM = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from fastlines.cli import main
sys.argv = ["fastlines", *sys.argv[1:]]
main()
"""


def test_a_page_is_served_until_ctrl_c():
    command = [sys.executable, "-u", "-c", PROGRAM, "view", SCENE, "--method", "bvh-d2", "--level", "3"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert "<Tree bvh-d2: 100 primitives" in process.stdout.readline()
        found = re.fullmatch(r"(http://127\.0\.0\.1:\d+)   \(Ctrl-C ends\)\n", process.stdout.readline())
        assert found is not None
        with urllib.request.urlopen(found[1]) as page:
            assert page.status == 200
        process.send_signal(signal.SIGINT)
        rest, errors = process.communicate(timeout=HANGS)
    assert (process.returncode, rest) == (0, "ended\n")
    assert re.fullmatch(r"(note: port 8080 is in use; the page is on port \d+\n)?", errors)


def test_a_page_is_written():
    told = done("view", SCENE, "--against", "bvh-cl", "--color", "depth", "--level", 2, "--export", "x.html")
    assert re.fullmatch(r"x.html: <Tree best: 100 primitives.*>\n", told)
    page = Path("x.html").read_text(encoding="utf-8")
    assert "depth: level of the leaf" in page
    assert "level 2 of" in page


def test_a_ray_may_be_given():
    done("view", SCENE, "--origin", "0.5,0.5,-1", "--direction", "0,0,1", "-r", 0.1, "--export", "x.html")
    hits = fl.build(fl.scenes.make("spaghetti", 100).lines).all_hits([[0.5, 0.5, -1]], [[0, 0, 1]], 0.1)
    page = Path("x.html").read_text(encoding="utf-8")
    assert f"<h4>{len(hits)} hit" in page
    assert "origin 0.5, 0.5, -1; direction 0, 0, 1; radius 0.1" in page


def test_a_tree_file_is_taken_as_it_is():
    fl.build(fl.scenes.make("spaghetti", 100).lines, "kd-cl").save("x.flt")
    assert "<Tree kd-cl" in done("view", "x.flt", "--export", "x.html")
    assert "x.flt is a tree already" in refused("view", "x.flt", "-m", "bvh-cl", "--export", "y.html")[1]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--export", "x.pdf"), "x.pdf: unknown extension for a page; expected .html"),
        (("--export", "x.html", "--port", 9999), "--port does not apply: --export serves nothing"),
        (("--origin", "0,0,0"), "--origin and --direction belong together"),
        (("--origin", "0,0", "--direction", "0,0,1", "--export", "x.html"), "--origin '0,0' is not three numbers"),
        (("--color", "deph", "--export", "x.html"), "did you mean 'depth'"),
        (("--level", 99, "--export", "x.html"), "level=99; expected a whole number"),
        (("--against", "bvh", "--export", "x.html"), "'bvh'"),
        (("--port", 70000), "'--port'"),
    ],
)
def test_a_wrong_option_is_one_sentence(options, sentence):
    assert sentence in refused("view", SCENE, *options)[1]


def test_a_port_in_use_is_one_sentence():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert f"port {port} is in use; choose another one" in refused("view", SCENE, "--port", port)[1]


def test_a_forest_and_no_lines_are_refused():
    fl.build_forest(fl.scenes.make("spaghetti", 100).lines, "forest")
    assert "is a forest" in refused("view", "forest")[1]
    Path("empty.csv").write_text("x,y,z\n")
    assert refused("view", "empty.csv")[0] == 1


def test_without_viser_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    assert "the viewer needs the extra 'view'" in refused("view", SCENE)[1]
