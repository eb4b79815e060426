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

import fastlines as fl
from fastlines.bench import embree
from fastlines.bench.embree import Scenes
from fastlines.bench.embree_tree import embree_tree, piece_boxes
from fastlines.bench.rays import camera_rays
from fastlines.bench.repeat import repeat_first
from fastlines.bench.visits import count_visits, visits_of_rays
from fastlines.demo.reference import THESIS
from fastlines.errors import FastlinesError, MissingExtraError
from fastlines.render import default_camera
from fastlines.report import FULL, QUICK, Plan, report_lines, report_thesis, run
from fastlines.report.claims import claims_of
from fastlines.report.depths import THESIS_DEPTHS, cylinders
from fastlines.report.heat import MOST, colour, visit_maps
from fastlines.report.peer import ribbons
from fastlines.report.rows import TIMES, Row, thesis_row
from fastlines.report.steps import Step, Store, run_steps
from fastlines.scenes import NAMES, RADII
from fastlines.settings import THESIS_METHODS

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


def has_embree() -> bool:
    try:
        embree.load(1)
    except FastlinesError:
        return False
    return True


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


@pytest.mark.skipif(not has_embree(), reason="Embree is not installed")
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


@pytest.mark.skipif(not has_embree(), reason="Embree is not installed")
def test_repeated_first_hits_are_all_hits():
    scene = fl.scenes.make("spaghetti", 80)
    rays = camera_rays(scene.camera, 48 * 48)
    scenes = Scenes(scene.lines, 0.01, scene.camera.origin, 1)
    found = repeat_first(scenes, ribbons(0.0), rays)
    expected = fl.build(scene.lines).count_hits(rays.origins, rays.directions, 0.01).sum()
    assert found.n_hits == pytest.approx(expected, rel=0.02)
    assert found.n_hits == pytest.approx(len(scenes.ask(ribbons(0.0), "all", rays).unpack()[0]), rel=0.01)


@pytest.mark.skipif(not has_embree(), reason="Embree is not installed")
def test_cost_of_a_tree_that_embree_made():
    def thin(*x):
        return fl.Lines.from_segments([[[a, 0, 0], [a, 1, 1]] for a in x])

    one = embree_tree(thin(0.0))
    assert (one.n_prims, one.n_nodes, one.cost) == (1, 1, 1.0)
    # Three flat boxes of area 1 at either end of one of area 1 + 2·99: c_trav = 2, then three with a chance of 1/199.
    six = embree_tree(thin(0.0, 0.0, 0.0, 99.0, 99.0, 99.0))
    assert (six.n_prims, six.n_nodes) == (6, 3)
    assert six.cost == pytest.approx(2 + 6 / 199)
    lines = fl.scenes.make("spaghetti", 300).lines
    whole, cut = embree_tree(lines), embree_tree(lines, 0.1)
    assert cut.n_prims == len(piece_boxes(lines, 0.1)[0]) > 300
    assert 1 < cut.cost < whole.cost <= 300
    assert whole.cost == pytest.approx(fl.build(lines, "bvh-cl").cost(), rel=0.1)


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
        assert text.count("not installed") == 2 * 10
    unknown = [claim for claim in told["claims"] if claim["holds"] is None or "spaghetti 2" in claim["text"]]
    assert unknown


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


def test_what_is_kept_must_be_whole_and_under_the_same_key(tmp_path):
    made = []

    def make(results):
        made.append(dict(results))
        (tmp_path / "a.png").write_bytes(b"x")
        return {"figure": 1, "images": {"it": "a.png"}}

    steps = [Step("A: §1", 1.0, make), Step("b", 1.0, lambda results: {"twice": 2 * results["A: §1"]["figure"]})]
    found = run_steps(steps, Store(tmp_path, 1))
    assert found["b"]["twice"] == 2
    assert run_steps(steps, Store(tmp_path, 1)) == found
    assert len(made) == 1
    run_steps(steps, Store(tmp_path, 2))
    assert len(made) == 2
    (tmp_path / "a.png").unlink()
    run_steps(steps, Store(tmp_path, 2))
    assert len(made) == 3
    Store(tmp_path, 2).path("A: §1", ".json").write_text('{"key"')
    run_steps(steps, Store(tmp_path, 2), show_progress=True)
    assert len(made) == 4


def test_progress_names_the_step_and_the_time_left(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "140")
    run_steps([Step(name, 1.0, lambda results: {}) for name in "abc"], Store(tmp_path, 1), show_progress=True)
    shown = capsys.readouterr().err
    assert "of 3" in shown


# --- What the thesis found ---


def thesis_tables():
    return {scene: {name: thesis_row(name, row) for name, row in rows.items()} for scene, rows in THESIS.items()}


def test_all_findings_hold_in_the_thesis_itself():
    claims = claims_of(thesis_tables())
    assert len(claims) == 7
    assert [claim.text for claim in claims if claim.holds is not True] == []


def test_a_finding_that_does_not_hold_is_told():
    tables = thesis_tables()
    rows = tables["photon-beams"]
    rows["bvh-ss"] = replace(rows["bvh-ss"], cost=3.01 * rows["bvh-d2"].cost)
    rows = tables["straight-hair"]
    rows["kd-d2"] = replace(rows["kd-d2"], cost=1.06 * rows["kd-cl"].cost)
    failed = {claim.text for claim in claims_of(tables) if claim.holds is False}
    assert failed == {"Only BVH::CL fails on photon beams.", "D2 changes little on hair."}


def test_what_was_not_measured_neither_holds_nor_fails():
    tables = thesis_tables()
    del tables["spaghetti-2"]["embree-ps"]
    tables["bun-hair"]["bvh-ss"] = Row("bvh-ss", {}, over_s=20.0)
    unknown = [claim.text for claim in claims_of(tables) if claim.holds is None]
    assert len(unknown) == 4
    assert "Only the D2 trees and Embree PS survive spaghetti 2." in unknown
    assert all(claim.holds is None for claim in claims_of({}))


def test_claims_in_json_follow_from_their_checks(told):
    assert len(told["claims"]) == 7
    for claim in told["claims"]:
        assert claim["checks"]
        assert claim["holds"] in (True, False, None)


# --- Pieces ---


def test_visits_of_rays_add_up():
    scene = fl.scenes.make("photon-beams", 200)
    tree = fl.build(scene.lines, "kd-d2")
    rays = camera_rays(scene.camera, 100)
    nodes, tests = visits_of_rays(tree, rays, 0.001)
    expected = count_visits(tree, rays, 0.001)
    assert tests.mean() == pytest.approx(expected.tests)
    hit_root = nodes > 0
    # Each inner node that is met shows both children to the ray; of these the ones that are met count.
    assert (nodes.mean() >= expected.inner) & (nodes[hit_root] >= 1).all()
    one = fl.build(scene.lines, splits=fl.PlaneGrid(8), lookahead=0)
    nodes, tests = visit_maps(one, scene.camera, 10, 0.001)
    assert set(np.unique(nodes)) <= {0.0, 1.0}
    assert (tests == 200 * nodes).all()


def test_colours_grow_lighter_with_the_count():
    picture = colour(np.array([[0.0, 1.0, 30.0, MOST, 10.0 * MOST]])).astype(int).sum(axis=2)[0]
    assert picture[0] == 0 < picture[1] < picture[2] < picture[3] == picture[4]


def test_cylinders_lie_in_the_cube():
    axes = cylinders(3)
    assert axes.shape == (100, 2, 3)
    assert ((axes >= 0) & (axes <= 4)).all()
    assert np.linalg.norm(axes[:, 1] - axes[:, 0], axis=1) == pytest.approx(np.ones(100))


def test_plans():
    assert set(FULL.scenes.values()) == {None}
    assert list(FULL.scenes) == list(QUICK.scenes) == list(NAMES)
    assert FULL.depths == QUICK.depths == (0, 1, 2, 3)


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
    assert f"W = {RADII['W'] * side:g}" in text


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
    assert "the build did not end within the limit" in text


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
        timeout=120,
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
