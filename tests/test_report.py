"""The report at a tiny size: what it writes, that it goes on where it was, and how it checks what the thesis found."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused
from command_line import run as run_command
from patience import HANGS
from peers import needs_embree

import fastlines as fl
from fastlines.demo.reference import THESIS
from fastlines.errors import MissingExtraError
from fastlines.methods import THESIS_METHODS
from fastlines.render import default_camera
from fastlines.report import Plan, report_lines, report_thesis, run
from fastlines.report.depths import THESIS_DEPTHS
from fastlines.report.rows import TIMES
from fastlines.scenes import NAMES, RADII

TINY = Plan(
    "tiny",
    scenes={"bun-hair": 300, "straight-hair": 300, "spaghetti": 100, "spaghetti-2": 120, "photon-beams": 150},
    size=32,
    budget=0.002,
    lengths=(0.0, 1 / 8, 1 / 32),
    picture=24,
    samples=1,
    heat=12,
    panel=32,
    levels=2,
    depths=(0, 1),
)
ONE = replace(TINY, scenes={"spaghetti": 60}, peer=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report") / "new" / "folder"
    assert report_thesis(folder, TINY) == folder / "index.html"
    return folder


@pytest.fixture(scope="module")
def told(folder):
    return json.loads((folder / "report.json").read_text(encoding="utf-8"))


# --- What is written ---


def test_json_has_every_row_and_figure(told):
    assert list(told["rows"]) == list(told["thesis"]) == list(NAMES)
    for scene, rows in told["rows"].items():
        assert set(THESIS_METHODS) < set(rows)
        for name, row in rows.items():
            assert list(row["ms"]) == [time for time in TIMES if "filter" not in name or time.startswith("all")]
            assert all(ms > 0 for ms in row["ms"].values())
            assert row["build_ms"] > 0
            if not name.startswith("embree"):
                assert row["n_prims"] == TINY.scenes[scene]
                assert row["cost"] > 0
    scene = fl.scenes.make("spaghetti", TINY.scenes["spaghetti"])
    for method, c_trav in (("best", 2.0), ("kd-d2", 0.6)):
        cost = fl.build(scene.lines, method).cost(model=fl.Cost(c_trav))
        assert told["rows"]["spaghetti"][method]["cost"] == cost
    assert told["n_compared"] == 5 * 6 * 2 * 32 * 32
    assert {"processor", "simd", "fastlines"} <= told["machine"].keys()


def test_thesis_stands_beside_in_the_tables(folder):
    text = (folder / "report.md").read_text(encoding="utf-8")
    for rows in THESIS.values():
        for reference in rows.values():
            assert f"({reference.cost:,.2f})" in text
    assert text.count("(not finished)") >= 6 * 7
    assert {len(rows) for rows in THESIS.values()} == {7}
    for cost, _ in list(THESIS_DEPTHS.values())[:2]:
        assert f"({cost:.1f})" in text
    tables = re.findall(r"((?:^\|.*\n)+)", text, re.MULTILINE)
    assert len(tables) >= 2 + 5 * 2 + 1
    for table in tables:
        assert len({re.sub(r"\\\|", "", row).count("|") for row in table.splitlines()}) == 1
    for file in re.findall(r"!\[[^]]*\]\((\S+)", text):
        assert (folder / file).is_file()


def test_page_holds_all_it_needs(folder):
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert not re.findall(r'(?:src|href)="(?!data:|#)', page)
    assert not re.findall(r"https?://|@import|url\(", page)
    assert set(re.findall(r'href="#([^"]+)"', page)) == set(re.findall(r'<section id="([^"]+)"', page))
    n_images = 5 * (3 + 2 * 6 + 3)
    assert page.count("<img") == page.count('src="data:image/png;base64,') == n_images
    assert all(alt for alt in re.findall(r'<img[^>]*alt="([^"]*)"', page))
    assert "@media print" in page
    assert "width=device-width" in page


@needs_embree
def test_embree_is_cut_to_the_length_that_was_best(told):
    for scene, rows in told["rows"].items():
        title = fl.scenes.make(scene, 10).title
        sweep = told["steps"][f"{title}: Embree’s lengths"]
        best = min(sweep["lengths"], key=lambda each: each["mean_ms"])
        assert len(sweep["lengths"]) == 3
        assert sweep["best"] == best["length"]
        assert rows["embree-ps"]["n_prims"] == rows["embree-ps-filter"]["n_prims"] == best["n_pieces"]
        assert rows["embree"]["n_prims"] == TINY.scenes[scene]
        assert rows["embree"]["cost"] > 0
        assert rows["embree-ps"]["n_nodes"] >= rows["embree"]["n_nodes"]
        assert rows["embree"]["ms"]["all M"] != rows["embree-filter"]["ms"]["all M"]
    assert told["missing"] == {}


def test_a_missing_peer_is_named_with_its_command(tmp_path, monkeypatch):
    def load(n_threads):
        raise MissingExtraError("The peer Embree", "bench")

    monkeypatch.setattr(run.embree, "load", load)
    report_thesis(tmp_path, replace(ONE, peer=True))
    told = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert set(told["rows"]["spaghetti"]) == {*THESIS_METHODS, "best"}
    for file in ("index.html", "report.md"):
        text = (tmp_path / file).read_text(encoding="utf-8")
        assert "fastlines[bench]" in text
        assert text.count("not installed") == 2
    unknown = [claim for claim in told["claims"] if claim["holds"] is None or "spaghetti 2" in claim["text"]]
    assert unknown


def test_a_missing_peer_is_named_in_the_report_of_a_file(monkeypatch, tmp_path):
    def load(n_threads):
        raise MissingExtraError("The peer Embree", "bench")

    monkeypatch.setattr(run.embree, "load", load)
    monkeypatch.setattr("fastlines.report.QUICK", replace(ONE, peer=True))
    page = tmp_path / "out" / "index.html"
    assert (
        "Embree is missing: The peer Embree"
        in run_command("report", "scene:spaghetti:50", "--quick", "-o", page.parent).stderr
    )
    text = page.read_text(encoding="utf-8")
    assert text.count("not installed") == 2
    assert text.count("fastlines[bench]") == 1
    assert "Of Embree" not in text


def test_claims_in_json_follow_from_their_checks(told):
    assert len(told["claims"]) == 8
    for claim in told["claims"]:
        assert claim["checks"]
        assert claim["holds"] in (True, False, None)


# --- Steps ---


def test_a_stopped_run_goes_on_where_it_was(tmp_path, monkeypatch):
    made = []
    before = run.tree_step

    def stop(subject, method, plan, store):
        if method == "kd-cl" and "kd-cl" not in made:
            made.append(method)
            raise KeyboardInterrupt
        made.append(method)
        return before(subject, method, plan, store)

    monkeypatch.setattr(run, "tree_step", stop)
    with pytest.raises(KeyboardInterrupt):
        report_thesis(tmp_path, ONE)
    assert not (tmp_path / "index.html").exists()
    page = report_thesis(tmp_path, ONE)
    assert made == ["bvh-cl", "bvh-ss", "bvh-d2", "kd-cl", "kd-cl", "kd-d2", "best"]
    first = json.loads((tmp_path / "report.json").read_text())["steps"]
    report_thesis(tmp_path, ONE)
    assert json.loads((tmp_path / "report.json").read_text())["steps"] == first
    assert len(made) == 7
    assert page.is_file()
    report_thesis(tmp_path, replace(ONE, size=16))
    assert len(made) == 7 + 6


@pytest.mark.usefixtures("in_own_folder")
def test_a_stopped_command_says_that_it_goes_on(monkeypatch):
    def stop(*args):
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "tree_step", stop)
    monkeypatch.setattr("fastlines.report.QUICK", ONE)
    result = run_command("report", "thesis", "--quick", "-o", "out")
    assert result.exit_code == 130
    assert "kept in out; the same command goes on" in result.stderr
    assert list(Path("out/steps").glob("*pictures.json"))


# --- Lines of one's own ---


def test_report_of_lines(tmp_path):
    scene = fl.scenes.make("photon-beams", 150)
    lines = fl.Lines.from_segments(1e3 * scene.lines.segments)
    camera = fl.Camera.framing(lines, (0, 0, -1))
    page = report_lines(tmp_path, replace(TINY, lengths=(0.0, 1 / 8)), "some/beams.npz", lines, camera)
    told = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert told["title"] == "beams.npz"
    assert "claims" not in told
    text = page.read_text(encoding="utf-8")
    assert "Which tree suits these lines" in text
    assert "is fastest" in text
    assert "thesis’s below" not in text
    side = float((lines.bounds[1] - lines.bounds[0]).max())
    assert f"W = {RADII['W'] * side:.3g}" in text


NASTY = {
    "one": [[[0, 0, 0], [1, 2, 3]]],
    "all in a point": np.ones((5, 2, 3)),
    "on an axis": [[[i, 0, 0], [i + 1, 0, 0]] for i in range(20)],
    "tiny": 1e-8 * fl.scenes.make("spaghetti", 40).lines.segments,
    "huge": 1e8 * fl.scenes.make("spaghetti", 40).lines.segments,
    "far away": 1e6 + fl.scenes.make("spaghetti", 40).lines.segments,
}


@pytest.mark.parametrize("name", NASTY)
def test_report_of_nasty_lines(tmp_path, name):
    lines = fl.Lines.from_segments(NASTY[name])
    plan = replace(TINY, size=16, lengths=(0.0, 1 / 8), methods=("bvh-cl", "kd-d2"))
    page = report_lines(tmp_path, plan, name, lines, default_camera(lines))
    rows = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["rows"]["lines"]
    assert all(row["ms"]["first M"] > 0 for row in rows.values() if "filter" not in row["name"])
    assert page.read_text(encoding="utf-8").count("<img") == 3 + 2 * 2 + 2


def test_a_build_over_the_limit_is_named(tmp_path):
    scene = fl.scenes.make("bun-hair", 4000)
    plan = replace(ONE, build_limit=0.0, methods=("kd-d2",))
    page = report_lines(tmp_path, plan, "it", scene.lines, scene.camera)
    text = page.read_text(encoding="utf-8")
    assert "over 0 s" in text
    assert "KD::D2: the build did not end within 0 s" in text


@pytest.mark.usefixtures("in_own_folder")
def test_command(monkeypatch):
    monkeypatch.setattr("fastlines.report.QUICK", ONE)
    assert "index.html" in done("report", "scene:spaghetti:50", "--quick", "-o", "out")
    assert Path("out/report.md").is_file()
    assert "index.html" in done("report", "thesis", "--quick", "-o", "thesis")
    code, said = refused("report", "nothing.npz", "-o", "out")
    assert code == 1
    assert "nothing.npz" in said


# --- In a browser ---

#: Clicks on each head of the first table of figures, and tells what the page has become.
PROBE = """
<script>
addEventListener("load", () => {
  const images = [...document.images];
  const head = document.querySelectorAll("section#spaghetti table.sortable")[0].tHead.rows[0].cells[4];
  const column = () => [...head.closest("table").tBodies[0].rows].map(row => row.cells[4].dataset.value);
  head.querySelector("button").click();
  const up = column();
  head.querySelector("button").click();
  document.body.dataset.probe = JSON.stringify({
    shown: images.filter(each => each.complete && each.naturalWidth > 0 && each.clientWidth > 0).length,
    images: images.length, up, down: column(), wide: document.documentElement.scrollWidth - innerWidth,
  });
});
</script></body>"""


@pytest.mark.parametrize("width", [390, 1280])
def test_page_in_a_browser(folder, told, tmp_path, width):
    browser = next(
        (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), ""
    )
    if not browser:
        pytest.skip("there is no Chromium here")
    page = tmp_path / "page.html"
    text = (folder / "index.html").read_text(encoding="utf-8")
    assert text.count("</body>") == 1
    page.write_text(text.replace("</body>", PROBE), encoding="utf-8")
    ran = subprocess.run(
        [
            browser,
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--enable-logging=stderr",
            "--virtual-time-budget=5000",
            f"--user-data-dir={tmp_path / 'profile'}",
            f"--window-size={width},900",
            "--dump-dom",
            page.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=HANGS,
    )
    assert ran.returncode == 0, ran.stderr
    assert [line for line in ran.stderr.splitlines() if "CONSOLE" in line] == []
    found = re.search(r"data-probe=\"([^\"]*)\"", ran.stdout)
    assert found, ran.stderr
    probe = json.loads(found[1].replace("&quot;", '"'))
    assert probe["shown"] == probe["images"] == 5 * 18
    costs = [float(value) for value in probe["up"] if value is not None]
    assert costs == sorted(costs)
    assert len(costs) == sum(row["cost"] is not None for row in told["rows"]["spaghetti"].values()) >= 6
    assert [float(value) for value in probe["down"] if value is not None] == costs[::-1]
    assert probe["wide"] <= 0, "wider than the screen"
