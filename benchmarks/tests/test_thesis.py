"""The report at a tiny size: what it writes, that it resumes, and how it checks the findings of the thesis."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import done
from command_line import run as run_command
from peers import needs_embree

import fastlines as fl
from fastlines.scenes import NAMES
from fastlines.settings.methods import THESIS_METHODS
from fastlines_bench.thesis import run
from fastlines_bench.thesis.depths import THESIS_DEPTHS
from fastlines_bench.thesis.preset import ThesisPreset
from fastlines_bench.thesis.reference import THESIS
from fastlines_bench.thesis.rows import TIMES
from fastlines_bench.thesis.run import make_thesis

TINY = ThesisPreset(
    name="tiny",
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
    assert make_thesis(folder, TINY) == folder / "index.html"
    return folder


@pytest.fixture(scope="module")
def report(folder):
    return json.loads((folder / "report.json").read_text(encoding="utf-8"))


# --- What is written ---


def test_json_has_every_row_and_figure(report):
    assert list(report["rows"]) == list(report["thesis"]) == list(NAMES)
    for scene, rows in report["rows"].items():
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
        assert report["rows"]["spaghetti"][method]["cost"] == cost
    assert report["n_compared"] == 5 * 6 * 2 * 32 * 32
    assert {"processor", "simd", "fastlines"} <= report["machine"].keys()


def test_tables_have_the_figures_of_the_thesis(folder):
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
def test_embree_is_cut_to_the_length_that_was_best(report):
    for scene, rows in report["rows"].items():
        title = fl.scenes.make(scene, 10).title
        sweep = report["steps"][f"{title}: Embree’s lengths"]
        best = min(sweep["lengths"], key=lambda each: each["mean_ms"])
        assert len(sweep["lengths"]) == 3
        assert sweep["best"] == best["length"]
        assert rows["embree-ps"]["n_prims"] == rows["embree-ps-filter"]["n_prims"] == best["n_pieces"]
        assert rows["embree"]["n_prims"] == TINY.scenes[scene]
        assert rows["embree"]["cost"] > 0
        assert rows["embree-ps"]["n_nodes"] >= rows["embree"]["n_nodes"]
        assert rows["embree"]["ms"]["all M"] != rows["embree-filter"]["ms"]["all M"]
    assert report["missing"] == {}


def test_a_missing_peer_is_named_with_its_command(tmp_path, monkeypatch):
    def load(n_threads):
        raise fl.FastlinesError("Embree needs the package embreex: run  pip install embreex")

    monkeypatch.setattr(run.embree, "load", load)
    make_thesis(tmp_path, replace(ONE, peer=True))
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert set(report["rows"]["spaghetti"]) == {*THESIS_METHODS, "best"}
    for file in ("index.html", "report.md"):
        text = (tmp_path / file).read_text(encoding="utf-8")
        assert "pip install embreex" in text
        assert text.count("not installed") == 2
    unknown = [claim for claim in report["findings"] if claim["holds"] is None or "spaghetti 2" in claim["text"]]
    assert unknown


def test_findings_in_json_follow_from_their_checks(report):
    assert len(report["findings"]) == 8
    for claim in report["findings"]:
        assert claim["checks"]
        assert claim["holds"] in (True, False, None)


# --- Steps ---


def test_an_interrupted_run_resumes(tmp_path, monkeypatch):
    made = []
    before = run.tree_step

    def stop(subject, method, preset, store):
        if method == "kd-cl" and "kd-cl" not in made:
            made.append(method)
            raise KeyboardInterrupt
        made.append(method)
        return before(subject, method, preset, store)

    monkeypatch.setattr(run, "tree_step", stop)
    with pytest.raises(KeyboardInterrupt):
        make_thesis(tmp_path, ONE)
    assert not (tmp_path / "index.html").exists()
    page = make_thesis(tmp_path, ONE)
    assert made == ["bvh-cl", "bvh-ss", "bvh-d2", "kd-cl", "kd-cl", "kd-d2", "best"]
    first = json.loads((tmp_path / "report.json").read_text())["steps"]
    make_thesis(tmp_path, ONE)
    assert json.loads((tmp_path / "report.json").read_text())["steps"] == first
    assert len(made) == 7
    assert page.is_file()
    make_thesis(tmp_path, replace(ONE, size=16))
    assert len(made) == 7 + 6


@pytest.mark.usefixtures("in_own_folder")
def test_an_interrupted_command_says_how_to_resume(monkeypatch):
    def stop(*args):
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "tree_step", stop)
    monkeypatch.setattr(ThesisPreset, "of", lambda quick, peer: ONE)
    result = run_command("thesis", "--quick", "-o", "out")
    assert result.exit_code == 130
    assert "kept in out; the same command resumes" in result.stderr
    assert list(Path("out/steps").glob("*pictures.json"))


@pytest.mark.usefixtures("in_own_folder")
def test_command(monkeypatch):
    monkeypatch.setattr(ThesisPreset, "of", lambda quick, peer: ONE)
    assert "index.html" in done("thesis", "--quick", "-o", "thesis")
    assert Path("thesis/report.md").is_file()


def test_a_build_over_the_limit_is_named(tmp_path):
    preset = replace(ONE, scenes={"bun-hair": 4000}, build_limit=0.0, methods=("best", "kd-d2"))
    assert "over 0 s" in make_thesis(tmp_path, preset).read_text(encoding="utf-8")


# --- In a browser ---

#: Clicks twice on a head of the first table of figures, and writes the state of the page into it.
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
def test_page_in_a_browser(folder, report, tmp_path, width):
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
        timeout=1800,
    )
    assert ran.returncode == 0, ran.stderr
    assert [line for line in ran.stderr.splitlines() if "CONSOLE" in line] == []
    found = re.search(r"data-probe=\"([^\"]*)\"", ran.stdout)
    assert found, ran.stderr
    probe = json.loads(found[1].replace("&quot;", '"'))
    assert probe["shown"] == probe["images"] == 5 * 18
    costs = [float(value) for value in probe["up"] if value is not None]
    assert costs == sorted(costs)
    assert len(costs) == sum(row["cost"] is not None for row in report["rows"]["spaghetti"].values()) >= 6
    assert [float(value) for value in probe["down"] if value is not None] == costs[::-1]
    assert probe["wide"] <= 0, "wider than the screen"
