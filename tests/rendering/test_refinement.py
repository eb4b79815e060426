"""Pictures that are shown before they are whole: a draft, how long the rest takes, and the cells of notebooks."""

from __future__ import annotations

import sys
import threading
import types

import numpy as np
import pytest

import fastlines as fl
from fastlines.rendering import (
    MEASURES,
    Pace,
    PictureOptions,
    Progressive,
    plan_picture,
    progressive,
    refined,
    refinement,
    renderer,
    renderer_of,
)
from fastlines.rendering.draft import SIDE, Draft, Grid
from fastlines.rendering.shading.density_grid import DensityGrid
from fastlines.threads import num_threads

LINES = fl.scenes.make("spaghetti", 80).lines
TREE = fl.build(LINES)


def made(look="tube", width=24, height=20, samples=3, **options):
    return renderer_of(
        plan_picture(
            TREE, PictureOptions(width=width, height=height, look=look, samples=samples, radius=0.02, **options)
        )
    )


def finished(one):
    for _ in one.passes():
        pass
    return one.picture()


# --- Drafts ---


@pytest.mark.parametrize(("width", "height"), [(1, 1), (3, 70), (70, 3), (64, 64), (131, 37)])
def test_a_draft_has_a_pixel_of_each_square(width, height):
    grid = Grid(width, height)
    groups = grid.groups(3, 1 << 16)
    parts = [grid.pixels(rows) for rows in groups]
    pixels = np.concatenate(parts)
    squares = set(zip((pixels // width // SIDE).tolist(), (pixels % width // SIDE).tolist(), strict=True))
    assert len(pixels) == len(squares) == -(-width // SIDE) * -(-height // SIDE)
    draft = Draft.of(grid, {"x": (), "none": (3,)}, groups, [{"x": part} for part in parts])
    shown = draft.rows("x", np.arange(height))
    assert shown.shape == (height, width)
    rows, columns = np.divmod(shown.astype(int), width)
    assert (rows // SIDE == np.arange(height)[:, None] // SIDE).all()
    assert (columns // SIDE == np.arange(width) // SIDE).all()
    assert not draft.rows("none", np.arange(height)).any()


@pytest.mark.parametrize(("n_groups", "max_squares"), [(1, 100), (3, 20), (50, 64), (2, 5)])
def test_no_group_of_a_draft_is_too_large(n_groups, max_squares):
    grid = Grid(40, 1600)  # 400 rows of 10 squares
    groups = grid.groups(n_groups, max_squares)
    assert max(len(grid.pixels(rows)) for rows in groups) <= max(10, max_squares)
    assert len(groups) > n_groups
    assert sorted(np.concatenate(groups).tolist()) == list(range(400))


@pytest.mark.parametrize("look", ["tube", "hair", "fibre", "id", "hits"])
def test_a_picture_is_the_same_after_a_draft(look):
    one = made(look)
    assert not one.has_picture
    assert one.seconds_left is None
    one.draw_draft()
    assert one.has_picture
    assert one.seconds_left > 0
    draft, whole, plain = one.picture(), finished(one), finished(made(look))
    assert (draft.samples, whole.samples) == (0, 3)
    assert draft.alpha.any()
    for name in ("light", "alpha", "shadow"):
        found = getattr(whole, name)
        assert (found is None and look == "hits") or (found == getattr(plain, name)).all()
    assert one.seconds_left == 0


def test_a_draft_shows_the_samples_of_its_pixels():
    one, first = made(), made(samples=1)
    one.draw_draft()
    pixels = Grid(24, 20).pixels(np.arange(5))
    draft, sample = one.picture(), finished(first)
    assert (draft.alpha.ravel()[pixels] == sample.alpha.ravel()[pixels]).all()
    assert (draft.light.reshape(-1, 3)[pixels] == sample.light.reshape(-1, 3)[pixels]).all()


def test_rows_with_samples_replace_those_of_the_draft(monkeypatch):
    monkeypatch.setattr(progressive, "MAX_RAYS", 150)  # bands of six rows
    one = made(samples=1)
    one.draw_draft()
    draft = one.picture()

    def stop(done):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list(one.passes(stop))
    found, whole = one.picture(), finished(made(samples=1))
    assert (found.light[:6] == whole.light[:6]).all()
    assert (found.light[6:] == draft.light[6:]).all()


def test_what_bands_share_is_made_before_they_have_threads(monkeypatch):
    """The lines are at the bottom of the picture, so that the first bands hit nothing."""
    found, grid_of = [], DensityGrid.of

    def of(*args):
        found.append(threading.current_thread())
        return grid_of(*args)

    monkeypatch.setattr(DensityGrid, "of", of)
    monkeypatch.setattr(progressive, "MAX_RAYS", 100)  # five bands
    camera = fl.Camera(origin=(0.5, 1.6, 4), target=(0.5, 1.6, 0), fov_degrees=60)
    with num_threads(4):
        picture = finished(made("hair", samples=1, camera=camera))
    assert found == [threading.main_thread()]
    assert not picture.alpha[:8].any()
    assert picture.alpha.any()


# --- Refinement ---


def test_only_a_large_picture_begins_with_a_draft(monkeypatch):
    for n_pixels, n_stages in ((24 * 20, 4), (24 * 20 + 1, 3)):
        monkeypatch.setattr(refinement, "LARGE", n_pixels)
        one = made()
        assert len(list(refined(one, None, pytest.fail))) == n_stages
        assert one.done == 3


@pytest.mark.parametrize("large", [1, 1 << 30])
def test_a_long_picture_says_how_long_before_it_starts(large, monkeypatch):
    monkeypatch.setattr(refinement, "LARGE", large)
    monkeypatch.setattr(refinement, "LONG", 0.0)
    one, said = made(), []
    next(refined(one, None, lambda sentence: said.append((sentence, one.done))))
    ((sentence, done),) = said
    assert sentence.startswith("this picture takes about ")
    assert done == (0 if large == 1 else 1)


def test_a_resumed_picture_says_how_long_the_rest_takes(tmp_path, monkeypatch):
    one = made()
    next(one.passes())
    one.save(tmp_path / "a.npz")
    monkeypatch.setattr(refinement, "LARGE", 1)
    monkeypatch.setattr(refinement, "LONG", 0.0)
    other, said = made(), []
    other.resume(tmp_path / "a.npz")
    assert len(list(refined(other, None, said.append))) == 2
    assert len(said) == 1
    assert (other.picture().light == finished(made()).light).all()


def test_a_picture_resumed_within_its_first_sample_says_how_long_after_the_second(tmp_path, monkeypatch):
    monkeypatch.setattr(progressive, "MAX_RAYS", 150)  # bands of six rows
    monkeypatch.setattr(refinement, "LONG", 0.0)

    def stop(done):
        raise KeyboardInterrupt

    one, other, said = made(), made(), []
    with pytest.raises(KeyboardInterrupt):
        list(one.passes(stop))
    one.save(tmp_path / "a.npz")
    other.resume(tmp_path / "a.npz")
    assert len(list(refined(other, None, lambda sentence: said.append((sentence, other.done))))) == 3
    ((sentence, done),) = said
    assert sentence.startswith("this picture takes about ")
    assert done == 2


def test_a_forecast_is_the_time_of_a_pass_by_what_is_left(monkeypatch):
    """The clock moves by a second for each band."""
    now = [0.0]
    sample = progressive.Progressive._sample_rows

    def slow(self, index, rows):
        now[0] += 1
        return sample(self, index, rows)

    monkeypatch.setattr(progressive, "MAX_RAYS", 100)  # five bands
    monkeypatch.setattr(progressive.Progressive, "_sample_rows", slow)
    monkeypatch.setattr(progressive.time, "perf_counter", lambda: now[0])
    monkeypatch.setenv("FASTLINES_NUM_THREADS", "1")
    one = made(samples=7)
    next(one.passes())
    assert one.seconds_left == 5 * 6


def test_pace_shows_the_first_picture_at_once_and_others_after_a_while(monkeypatch):
    now, shown = [50.0], []
    monkeypatch.setattr(refinement.time, "perf_counter", lambda: now[0])
    pace = Pace(3.0)

    def show():
        shown.append(now[0])
        now[0] += 0.5  # which is a tenth of five seconds

    for _ in range(20):
        pace.show(100.0, show)
        now[0] += 1
    assert shown == [50.0, 55.5, 61.0, 66.5]
    assert pace.n_shown == 4
    now[0] += 1000
    assert not pace.show(0.5, show)  # the whole picture is there soon


# --- Notebooks ---


class Shell:
    """A kernel of IPython: it keeps what is displayed."""

    kernel = True
    execution_count = 1

    def __init__(self):
        self.shown = []

    def display(self, shown, display_id):
        assert display_id is True
        self.shown.append(shown)
        return types.SimpleNamespace(update=self.shown.append)


@pytest.fixture
def shell(monkeypatch):
    shell = Shell()
    ipython, display = types.ModuleType("IPython"), types.ModuleType("IPython.display")
    ipython.get_ipython = lambda: shell
    display.Image = lambda data, format: data
    display.display = shell.display
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setattr(refinement, "WAITED", 0.0)
    monkeypatch.setattr(refinement, "LARGE", 1)
    monkeypatch.setattr(renderer, "CELL_SECONDS", 0.0)
    monkeypatch.setattr(refinement, "SHARE", 1e9)
    return shell


SMALL = {"width": 24, "height": 20, "radius": 0.02, "samples": 3, "look": "tube"}


def test_a_cell_shows_a_picture_while_it_is_made(shell):
    picture = fl.render(TREE, **SMALL)
    assert len(shell.shown) >= 4  # the draft, samples, and the whole picture
    assert all(shown[1:4] == b"PNG" for shown in shell.shown)
    assert shell.shown[0] != shell.shown[-1] == picture._repr_png_()
    assert (picture.light == finished(made()).light).all()
    # The value of the cell is not shown a second time, but in the next cell, and so is another picture.
    assert picture._ipython_display_() is None
    with pytest.raises(NotImplementedError):
        picture.with_legend()._ipython_display_()
    shell.execution_count += 1
    with pytest.raises(NotImplementedError):
        picture._ipython_display_()


def test_a_short_picture_and_a_terminal_show_nothing_meanwhile(shell, monkeypatch):
    monkeypatch.setattr(refinement, "WAITED", 1e9)
    with pytest.raises(NotImplementedError):
        fl.render(TREE, **SMALL)._ipython_display_()
    monkeypatch.setattr(refinement, "WAITED", 0.0)
    monkeypatch.delattr(Shell, "kernel")
    fl.render(TREE, **SMALL)
    assert shell.shown == []


@pytest.mark.parametrize("is_notebook", [False, True])
def test_an_interrupt_keeps_the_picture_in_a_notebook(is_notebook, shell, monkeypatch):
    passes = Progressive.passes

    def stopped(self, progress=None):
        yield next(passes(self, progress))
        raise KeyboardInterrupt

    monkeypatch.setattr(Progressive, "passes", stopped)
    if not is_notebook:
        monkeypatch.delattr(Shell, "kernel")
        with pytest.raises(KeyboardInterrupt):
            fl.render(TREE, **SMALL)
        return
    picture = fl.render(TREE, **SMALL)
    assert picture.samples == 1
    assert shell.shown[-1] == picture._repr_png_()


def test_render_says_how_long_on_stderr(capsys, monkeypatch):
    fl.render(TREE, **SMALL)
    assert capsys.readouterr() == ("", "")
    monkeypatch.setattr(refinement, "LONG", 0.0)
    fl.render(TREE, **SMALL)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("fastlines: this picture takes about ")


def test_measures_have_drafts():
    one = made("hits")
    assert type(one.measure) is type(MEASURES["hits"])
    one.draw_draft()
    assert one.picture().aovs["hits"].any()
