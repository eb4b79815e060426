"""The viewer without a browser: what it refuses, what it says, and how it begins and ends."""

from __future__ import annotations

import re
import socket
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import fastlines as fl
from fastlines.inspection import trace_ray
from fastlines.viewer.latest import Latest
from fastlines.viewer.server import free_port
from fastlines.viewer.view import make_panes
from fastlines.viewer.viewer import Viewer

TREE = fl.build(fl.scenes.make("spaghetti", 300).lines, "bvh-d2")


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    pytest.importorskip("viser")
    with fl.view(TREE, against="bvh-cl", level=3) as made:
        yield made


@pytest.fixture
def taken_port() -> Iterator[int]:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        yield taken.getsockname()[1]


BAD = {
    "array": (lambda: fl.view(np.zeros((1, 2, 3))), "tree is ndarray; expected a Tree: build one first"),
    "theory": (
        lambda: fl.view(fl.theory.build(fl.theory.segments([[[0, 0, 0], [1, 1, 1]]]), fl.theory.object_sweep)),
        "tree is Node; .*fl.drawing",
    ),
    "forest": (lambda: fl.view(object.__new__(fl.Forest)), "tree is Forest; .*over some of the lines"),
    "empty": (lambda: fl.view(fl.build(np.empty((0, 2, 3)))), "over no primitives, so there is nothing to view"),
    "other lines": (lambda: fl.view(TREE, against=fl.build([[[0, 0, 0], [1, 1, 1]]])), "over the same lines"),
    "method": (lambda: fl.view(TREE, against="bvh-cd"), "did you mean"),
    "color": (lambda: fl.view(TREE, color="deph"), "did you mean 'depth'"),
    "level": (lambda: fl.view(TREE, level=99), "level=99; expected a whole number, 0 to"),
    "radius": (lambda: fl.view(TREE, radius=-1), "radius=-1"),
    "port": (lambda: fl.view(TREE, port=-1), "port=-1; expected a whole number, 0 to 65535"),
    "high port": (lambda: fl.view(TREE, port=70000), "port=70000"),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_input_is_refused_in_one_sentence(what: str) -> None:
    pytest.importorskip("viser")
    call, sentence = BAD[what]
    with pytest.raises(fl.InputError, match=sentence) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_a_port_in_use_is_refused(taken_port: int) -> None:
    pytest.importorskip("viser")
    with pytest.raises(fl.InputError, match=f"port {taken_port} is in use; choose another one"):
        fl.view(TREE, port=taken_port)


def test_another_port_is_taken_if_none_is_given(taken_port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    free = free_port(None)
    monkeypatch.setattr("fastlines.viewer.server.PORTS", [taken_port, free])
    assert free_port(None) == free
    monkeypatch.setattr("fastlines.viewer.server.PORTS", [taken_port])
    with pytest.raises(fl.InputError, match="all in use"):
        free_port(None)


def test_without_viser_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(fl.MissingExtraError, match="needs the extra 'view'"):
        fl.view(TREE)


def test_trees_of_the_same_method_have_different_names() -> None:
    assert [pane.name for pane in make_panes(TREE, TREE)] == ["bvh-d2 1", "bvh-d2 2"]


def test_costs_of_both_trees_are_those_of_the_first_ones_steps() -> None:
    panes = make_panes(TREE, "kd-cl")
    assert [pane.outline.model for pane in panes] == [TREE.settings.cost] * 2
    assert panes[1].tree.settings.cost != TREE.settings.cost


def test_a_viewer_is_silent_serves_on_the_loopback_address_and_ends(capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("viser")
    first = fl.view(TREE)
    second = fl.view(TREE)
    assert first.url != second.url
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+", first.url)
    with urllib.request.urlopen(first.url) as page:
        assert b"<html" in page.read()
    assert f'<iframe src="{first.url}"' in first._repr_html_()
    first.close()
    first.close()
    second.close()
    assert repr(first) == "<Viewer of bvh-d2: closed>"
    assert "closed" in first._repr_html_()
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(first.url)
    assert capfd.readouterr() == ("", "")


def test_pages_of_other_sites_do_not_reach_the_scene(viewer: Viewer) -> None:
    client = pytest.importorskip("websockets.sync.client")
    exceptions = pytest.importorskip("websockets.exceptions")
    address, protocol = viewer.url.replace("http", "ws"), [f"viser-v{pytest.importorskip('viser').__version__}"]
    with client.connect(address, origin=viewer.url, subprotocols=protocol) as own:
        assert len(own.recv()) > 0
    with pytest.raises(exceptions.InvalidStatus, match="403"):
        client.connect(address, origin="https://elsewhere.example", subprotocols=protocol)


def test_a_ray_is_followed_through_both_trees(viewer: Viewer) -> None:
    viewer.shoot([0.5, 0.5, -1], [0, 0, 1], 0.02)
    viewer.wait()
    expected = TREE.all_hits([[0.5, 0.5, -1]], [[0, 0, 1]], 0.02)
    shown = viewer._panel.way.content
    assert f"{len(expected)} hits" in shown
    way = trace_ray(TREE, [0.5, 0.5, -1], [0, 0, 1], 0.02)
    assert f"<td>bvh-d2</td><td>{way.n_steps}</td><td>{way.n_tests}</td><td>{way.cost:.6g}</td>" in shown
    assert "<td>bvh-cl</td>" in shown
    assert viewer._panel.origin.value == "0.5, 0.5, -1"
    assert viewer._panel.step.max >= len(way.nodes)
    viewer.shoot([0.5, 0.5, -1], [0, 0, 1], query="first")
    viewer.wait()
    assert "<h4>1 hit</h4>" in viewer._panel.way.content


@pytest.mark.parametrize(
    ("ray", "sentence"),
    [
        (([0, 0], [0, 0, 1]), "expected three numbers each"),
        (([0, 0, 0], [0, 0, 0]), "length zero"),
        (([0, 0, np.nan], [0, 0, 1]), "not finite|NaN"),
        (([0, 0, 0], [0, 0, 1], -1.0), "radius"),
    ],
)
def test_a_ray_that_is_none_is_refused(viewer: Viewer, ray: tuple[list[float], ...], sentence: str) -> None:
    with pytest.raises(fl.InputError, match=sentence):
        viewer.shoot(*ray)


def test_a_ray_with_too_many_hits_is_refused_on_the_page(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fastlines.viewer.pane.MAX_HITS", 10)
    viewer.shoot([0.5, 0.5, -1], [0, 0, 1], 0.1, query="all")
    viewer.wait()
    assert "follows at most 10: lower the radius" in viewer._panel.note.content
    assert viewer._panel.way.content == '<div class="fl"></div>'  # not the hits of another radius
    viewer.shoot([0.5, 0.5, -1], [0, 0, 1], 0.001)
    viewer.wait()
    assert viewer._panel.note.content == ""


def test_a_node_is_picked_and_let_go(viewer: Viewer) -> None:
    viewer.pick(7)
    viewer.wait()
    assert "node 7" in viewer._panel.path.content or "leaf 7" in viewer._panel.path.content
    assert viewer._panel.node.value == 7
    viewer.pick(None)
    viewer.wait()
    assert viewer._panel.path.content == '<div class="fl"></div>'
    with pytest.raises(fl.InputError, match="node=99999; expected a number from 0"):
        viewer.pick(99999)


def test_a_click_is_a_ray_of_the_tree_under_it(viewer: Viewer) -> None:
    drawing = viewer._drawing
    viewer.choices.side = 2
    try:
        for i, (_, place) in enumerate(drawing._places()):
            index, ray = drawing.ray_of_click(place + np.array([0.1, 0.2, -20.0]), (0.0, 0.0, 1.0))
            assert index == i
            given = viewer._drawing.stage.frame.to_given(np.array([0.1, 0.2, -20.0]))
            assert ray.origin == pytest.approx(given.tolist(), abs=1e-5)
    finally:
        viewer.choices.side = 0


def test_a_click_hits_the_line_under_it_far_from_the_origin() -> None:
    pytest.importorskip("viser")
    random = np.random.default_rng(0)
    starts = random.uniform(0, 100, (200, 1, 3))
    segments = np.concatenate([starts, starts + random.normal(0, 3, (200, 1, 3))], axis=1)
    tree = fl.build(fl.lines(segments + np.array([4.5e6, 5.1e5, 300.0]), offset="auto"))
    eye = np.array([3.0, -20, 9])
    with fl.view(tree, radius=0.001) as viewer:
        frame = viewer._drawing.stage.frame
        for i in range(20):
            target = frame.to_page(tree.geometry.segments[i].astype(np.float64).mean(axis=0))
            ray = viewer._drawing.ray_of_click(eye, target - eye)[1]
            assert i in tree.all_hits([ray.origin], [ray.direction], 0.001).prim


def test_what_is_left_out_of_the_way_is_said(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fastlines.viewer.pane.MAX_VISITED", 5)
    monkeypatch.setattr("fastlines.viewer.pane.MAX_POINTS", 3)
    viewer.shoot([0.5, 0.5, -1], [0, 0, 1], 0.1, query="all")
    viewer.wait()
    way = trace_ray(TREE, [0.5, 0.5, -1], [0, 0, 1], 0.1)
    shown = viewer._panel.way.content
    assert f"the last 5 of {len(way.nodes)} boxes are shown" in shown
    assert f"the first 3 of {len(way.hits)} hits are shown" in shown


def test_a_ray_that_is_refused_changes_nothing(viewer: Viewer) -> None:
    viewer.shoot([0.5, 0.5, -1], [0, 0, 1], 0.02, query="all")
    before = viewer.choices.ray
    with pytest.raises(fl.InputError, match="query='x'"):
        viewer.shoot([9, 9, 9], [0, 0, 1], 0.5, query="x")  # type: ignore[arg-type]
    assert (viewer.choices.ray, viewer.choices.radius, viewer.choices.query) == (before, 0.02, "all")


def test_a_closed_viewer_says_so() -> None:
    pytest.importorskip("viser")
    viewer = fl.view(TREE)
    viewer.close()
    for call in (lambda: viewer.shoot([0, 0, 0], [0, 0, 1]), lambda: viewer.pick(0), viewer.wait):
        with pytest.raises(fl.InputError, match=r"this viewer is closed; fl\.view makes another one"):
            call()


def test_a_click_beside_all_lines_picks_nothing(viewer: Viewer) -> None:
    with pytest.raises(fl.InputError, match="no line is near that place"):
        viewer._drawing.pick((500.0, 500.0, -20.0), (0.0, 0.0, 1.0), 0.01)


def test_a_page_is_one_file_with_its_texts(viewer: Viewer, tmp_path: Path) -> None:
    viewer.shoot([0.5, 0.5, -1], [0, 0, 1], 0.02)
    viewer.export(tmp_path / "x.html")
    page = (tmp_path / "x.html").read_text(encoding="utf-8")
    assert page.count("__VISER_EMBED_DATA__=") == 1
    overlay = page[page.rindex('<details id="fl"') :]
    assert "The ray in each tree" in overlay
    assert "level 3 of" in overlay
    assert "radius 0.02" in overlay
    assert len(page) < 3e6
    with pytest.raises(fl.InputError, match=r"unknown extension for a page; expected \.html"):
        viewer.export(tmp_path / "x.pdf")


def test_large_coordinates_are_shown_near_zero_and_told_as_they_are(tmp_path: Path) -> None:
    pytest.importorskip("viser")
    lines = fl.lines(np.array([[[5e6, 0, 0], [5e6 + 1, 1, 1]]]), offset=[5e6, 0, 0])
    with fl.view(fl.build(lines), radius=0.1) as viewer:
        viewer.shoot([5e6 + 0.5, 0.5, -1], [0, 0, 1])
        viewer.wait()
        assert "1 hit" in viewer._panel.way.content
        frame = viewer._drawing.stage.frame
        assert np.abs(frame.given_to_page(np.array([5e6 + 0.5, 0.5, 0.5]))).max() < 1e-6


@pytest.mark.parametrize(
    "geometry",
    [
        fl.lines([[[1, 2, 3], [1, 2, 3]]]),  # a point
        fl.lines([[[0, 0, 0], [1e-8, 0, 0]]]),
        fl.lines([[[0, 0, 0], [1e8, 0, 0]]]),
        fl.Geometry(
            [fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]), fl.Spheres.from_centres([[0, 0, 1]], radius=1)]
        ),
        fl.Curves.from_bezier(np.random.default_rng(1).uniform(0, 1, (3, 4, 3)), radius=0.1),
    ],
    ids=["point", "tiny", "huge", "parts", "curves"],
)
def test_any_geometry_is_shown(geometry: fl.Lines | fl.Geometry | fl.Curves) -> None:
    pytest.importorskip("viser")
    with fl.view(fl.build(geometry)) as viewer:
        viewer.choices.lines = "those that the ray tests"
        middle = np.asarray(geometry.bounds, np.float64).mean(axis=0)
        viewer.shoot(middle - [0.01, 0.02, 2], [0.01, 0.02, 2])
        viewer.pick(0)
        viewer.wait()
        assert viewer._panel.note.content == ""
        assert "hit" in viewer._panel.way.content


def test_errors_of_orders_are_reported_and_the_next_order_is_done() -> None:
    errors, done = list[Exception](), list[int]()
    worker = Latest(errors.append)
    worker.order("a", lambda: 1 / 0)
    worker.order("b", lambda: done.append(1))
    worker.wait()
    worker.close()
    worker.order("c", lambda: done.append(2))
    assert isinstance(errors[0], ZeroDivisionError)
    assert done == [1]


def test_a_browser_that_has_gone_away_is_no_error(viewer: Viewer, capfd: pytest.CaptureFixture[str]) -> None:
    class Gone:
        def __getattr__(self, name: str) -> None:
            raise RuntimeError("Render request failed: the client disconnected before returning a frame.")

    viewer._order("screenshot", Gone())
    viewer.wait()
    assert "gone away" in viewer._panel.note.content
    assert capfd.readouterr() == ("", "")
