"""The viewer in a browser: levels, a picked leaf, rays by a click, the radius slider, a second tree, saved pages."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import fastlines as fl
from fastlines.viewer.choices import NONE
from fastlines.viewer.viewer import Viewer

sync_api = pytest.importorskip("playwright.sync_api")
pytest.importorskip("viser")
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")]

#: WebGL by software, and nothing that Chromium itself would ask of the network.
ARGUMENTS = [
    *("--no-sandbox", "--disable-gpu-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"),
]
LINES = fl.scenes.make("spaghetti", 200).lines
TREE = fl.build(LINES, "kd-d2")


class Page:
    """A browser's page of a viewer, with what it has asked for and what has gone wrong there."""

    def __init__(self, browser: object, url: str) -> None:
        self.asked, self.errors = list[str](), list[str]()
        self.page = browser.new_page(viewport={"width": 1280, "height": 800})
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("websocket", lambda socket: self.asked.append(socket.url))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda said: self.errors.append(said.text) if said.type == "error" else None)
        self.page.goto(url)

    def choose(self, label: str, option: str) -> None:
        self.page.get_by_label(label, exact=True).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name).click()

    def control(self, label: str, role: str) -> object:
        """Return the slider or the text box beside a label."""
        row = self.page.locator("label", has_text=re.compile(f"^{label}$")).locator("xpath=../../..")
        return row.get_by_role(role)

    def slider(self, label: str) -> object:
        return self.control(label, "slider")

    def expect(self, text: str | re.Pattern[str]) -> None:
        sync_api.expect(self.page.locator("body")).to_contain_text(text, timeout=20_000)

    def until(self, holds: Callable[[], bool]) -> None:
        """Wait until something holds, while the page goes on."""
        for _ in range(200):
            if holds():
                return
            self.page.wait_for_timeout(100)
        raise AssertionError("nothing has happened for 20 seconds")

    def rows(self, heading: str) -> list[list[str]]:
        """Return the texts of the table below a heading."""
        table = self.page.locator("h4", has_text=heading).locator("xpath=following-sibling::div[1]")
        return [row.locator("td").all_inner_texts() for row in table.locator("tr").all()[1:]]


@pytest.fixture(scope="module")
def browser() -> Iterator[object]:
    with sync_api.sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield opened
        opened.close()


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    with fl.view(TREE, against="bvh-cl", level=2, radius=0.004) as made:
        yield made


@pytest.fixture
def page(browser: object, viewer: Viewer) -> Iterator[Page]:
    made = Page(browser, viewer.url)
    made.expect("200 segments, all shown")
    yield made
    made.page.close()
    viewer.wait()
    assert made.errors == []
    own = ("http://127.0.0.1", "ws://127.0.0.1", "blob:http://127.0.0.1", "data:")
    assert [url for url in made.asked if not url.startswith(own)] == []


def click(page: Page) -> None:
    """Click the middle of the scene as soon as the camera is there."""
    page.page.wait_for_timeout(1500)
    page.page.mouse.click(440, 400)


def test_levels_planes_and_colours(page: Page, viewer: Viewer) -> None:
    page.choose("Colour by", "leaf size")
    page.expect("leaf size: references in the leaf")
    page.tab("Tree")
    page.expect("kd-d2, level 2 of")
    page.slider("Level").press("ArrowRight")
    page.expect("kd-d2, level 3 of")
    page.page.get_by_role("checkbox").nth(1).click()
    page.expect(re.compile(r"kd-d2, \d+ split plane"))
    page.choose("Tree shown", "both, side by side")
    page.expect("bvh-cl, level 3 of")
    assert (viewer.choices.level, viewer.choices.side, viewer.choices.planes) == (3, 2, True)


def test_a_leaf_is_picked(page: Page, viewer: Viewer) -> None:
    page.tab("Tree")
    page.page.get_by_label("Node", exact=True).fill("5")
    page.page.keyboard.press("Enter")
    page.expect("node 5: ")
    page.choose("A click", "picks a leaf")
    click(page)
    page.expect(re.compile(r"kd-d2, leaf \d+: \d+ reference"))
    assert viewer.choices.node is not None
    path = viewer._panes[0].outline.path(viewer.choices.node[1])
    assert [int(row[0]) for row in page.rows("kd-d2, leaf")] == path.tolist()
    page.page.get_by_text("Clear the picked node").click()
    page.until(lambda: viewer.choices.node is None)


def test_a_click_shoots_a_ray_whose_hits_are_those_of_the_api(page: Page, viewer: Viewer) -> None:
    page.tab("Ray")
    click(page)
    page.expect("The ray in each tree")
    assert viewer.choices.ray is not None
    asked = viewer.choices.ray
    for _ in range(3):
        viewer.wait()
        hits = TREE.all_hits([asked.origin], [asked.direction], viewer.choices.radius)
        page.expect(f"{len(hits)} hits" if len(hits) != 1 else "1 hit")
        listed = [row[1:] for row in page.rows(f"{len(hits)} hit")] if len(hits) else []
        expected = zip(hits.prim, hits.strand, hits.t, hits.distance, strict=True)
        assert listed == [[f"{p}", f"{s}", f"{t:.6g}", f"{d:.4g}"] for p, s, t, d in expected][:30]
        assert [row[0] for row in page.rows("The ray in each tree")] == ["kd-d2", "bvh-cl"]
        before = viewer.choices.radius
        for _ in range(10):
            page.slider("Radius, log₁₀").press("ArrowRight")
        wanted = pytest.approx(before * 10**0.1, rel=0.02)
        page.until(lambda wanted=wanted: viewer.choices.radius == wanted)


def test_a_ray_that_is_typed(page: Page, viewer: Viewer) -> None:
    page.tab("Ray")
    page.control("Origin", "textbox").fill("0.5, 0.5, -1")
    page.control("Direction", "textbox").fill("0 0 up")
    page.page.wait_for_timeout(300)
    page.page.get_by_text("Shoot this ray").click()
    page.expect("direction '0 0 up' is not three numbers")
    page.control("Direction", "textbox").fill("0, 0, 1")
    page.page.wait_for_timeout(300)
    page.page.get_by_text("Shoot this ray").click()
    page.expect("The ray in each tree")
    page.control("Radius", "textbox").fill("0.02005")  # to the last digit, and beyond the slider
    page.until(lambda: viewer.choices.radius == 0.02005)
    hits = TREE.all_hits([[0.5, 0.5, -1]], [[0, 0, 1]], 0.02005)
    page.expect(f"{len(hits)} hits")
    page.choose("Find", "the first hit")
    page.expect("1 hit")
    page.slider("Step").press("Home")
    page.slider("Step").press("ArrowRight")
    page.expect("kd-d2, step 1 of")


def test_a_screenshot_and_a_page(page: Page, viewer: Viewer, browser: object, tmp_path: Path) -> None:
    viewer.shoot([0.5, 0.5, -1], [0, 0, 1])
    page.tab("Save")
    page.page.wait_for_timeout(1500)
    with page.page.expect_download(timeout=60_000) as saved:
        page.page.get_by_text("Screenshot (PNG)").click()
    saved.value.save_as(tmp_path / "x.png")
    from PIL import Image

    pixels = np.asarray(Image.open(tmp_path / "x.png"))
    assert pixels.shape[0] == 800
    assert (np.ptp(pixels, axis=2) > 40).sum() > 1000  # coloured lines on grey

    with page.page.expect_download(timeout=60_000) as saved:
        page.page.get_by_text("This scene as a page").click()
    saved.value.save_as(tmp_path / "x.html")
    page.page.goto("about:blank")  # leaves the processors to the other page
    offline = Page(browser, (tmp_path / "x.html").as_uri())
    offline.expect("The ray in each tree")
    offline.expect("200 segments, all shown")
    offline.page.wait_for_timeout(3000)
    offline.page.screenshot(path=tmp_path / "page.png", timeout=60_000)
    assert (np.ptp(np.asarray(Image.open(tmp_path / "page.png"))[..., :3], axis=2) > 40).sum() > 1000
    assert offline.errors == []
    assert [url for url in offline.asked if not url.startswith(("file:", "data:", "blob:"))] == []
    offline.page.close()


def test_a_page_that_is_closed_while_a_slider_moves(
    page: Page, viewer: Viewer, browser: object, capfd: pytest.CaptureFixture[str]
) -> None:
    viewer.shoot([0.5, 0.5, -1], [0, 0, 1])
    page.tab("Ray")
    thumb = page.slider("Radius, log₁₀")
    box = thumb.bounding_box()
    page.page.mouse.move(box["x"], box["y"] + 5)
    page.page.mouse.down()
    for i in range(12):
        page.page.mouse.move(box["x"] - 3 * i, box["y"] + 5)
    page.page.close()
    viewer.wait()
    again = Page(browser, viewer.url)  # a new browser sees what has been chosen
    again.tab("Ray")
    again.expect("The ray in each tree")
    again.page.close()
    assert capfd.readouterr() == ("", "")


def test_two_browsers_share_what_is_chosen(page: Page, viewer: Viewer, browser: object) -> None:
    viewer.shoot([0.5, 0.5, -1], [0, 0, 1])
    viewer.choices.lines = NONE
    other = Page(browser, viewer.url)
    other.tab("Tree")
    page.tab("Tree")
    other.slider("Level").press("ArrowRight")
    page.expect("kd-d2, level 3 of")
    other.expect("kd-d2, level 3 of")
    other.page.close()
    assert other.errors == []
