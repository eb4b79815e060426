"""Progressive passes: their radii, their mean and variance, and how they go on after a break."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import fastlines as fl
from fastlines.beams import BeamPicture, BeamScene, GridMedium, Passes, PassSettings, PointLight, example, render
from fastlines.beams.passes import TRACING

SMALL = {"width": 12, "height": 9, "n_paths": 300}


def added(n, **settings):
    passes = Passes(example("glass-sphere"), **{**SMALL, **settings})
    for _ in range(n):
        passes.add()
    return passes


def test_radii_shrink_as_alpha_says():
    def radii(n, **settings):
        return [PassSettings(**settings).radius_of(example("point-light"), i) for i in range(n)]

    assert radii(3, radius=2.0, alpha=1.0) == [2.0, 2.0, 2.0]
    beam, point = (radii(4, alpha=0.5, estimator=name) for name in ("beam", "point"))
    assert beam == pytest.approx([0.01, 0.01 * 0.75, 0.01 * 0.75 * 2.5 / 3, 0.01 * 0.75 * 2.5 / 3 * 3.5 / 4])
    assert point == pytest.approx(0.01 * np.sqrt(np.array(beam) / 0.01))


def test_a_picture_is_the_mean_of_its_passes_with_their_variance():
    whole = added(3, alpha=1.0).picture()
    single = []
    passes = Passes(example("glass-sphere"), **SMALL, alpha=1.0)
    before = 0.0
    for i in range(3):
        passes.add()
        total = passes.picture().radiance.astype(np.float64) * (i + 1)
        single.append(total - before)
        before = total
    assert np.allclose(whole.radiance, np.mean(single, axis=0), rtol=1e-5)
    assert np.allclose(whole.variance, np.var(single, axis=0, ddof=1) / 3, rtol=1e-3, atol=1e-9)
    assert (whole.n_passes, whole.n_paths) == (3, 900)
    assert np.isnan(added(1).picture().variance).all()


def test_passes_go_on_where_they_were(tmp_path):
    first = added(2)
    first.save(tmp_path / "state.npz")
    again = Passes(example("glass-sphere"), **SMALL)
    again.resume(tmp_path / "state.npz")
    assert again.done == 2
    again.add()
    whole = added(3).picture()
    assert (again.picture().radiance == whole.radiance).all()
    assert (again.picture().variance == whole.variance).all()
    assert again.picture().radius == whole.radius


def test_a_state_of_another_picture_is_refused(tmp_path):
    added(1).save(tmp_path / "state.npz")
    with pytest.raises(fl.InputError, match="seed was 0, and is 1"):
        Passes(example("glass-sphere"), **SMALL, seed=1).resume(tmp_path / "state.npz")
    with pytest.raises(fl.InputError, match="the scene differs"):
        Passes(example("point-light"), **SMALL).resume(tmp_path / "state.npz")


def test_grids_of_the_same_numbers_in_another_shape_are_other_scenes(tmp_path):
    def passes(shape):
        smoke = GridMedium(np.arange(1, 7).reshape(shape), [[-1, -1, -1], [1, 1, 1]], 0, 1)
        scene = BeamScene(smoke, [PointLight((0, 0, 0), 1)], camera=fl.Camera((0, 0, 5), (0, 0, 0)))
        return Passes(scene, **SMALL)

    passes((3, 2, 1)).save(tmp_path / "state.npz")
    passes((3, 2, 1)).resume(tmp_path / "state.npz")
    with pytest.raises(fl.InputError, match="the scene differs"):
        passes((1, 2, 3)).resume(tmp_path / "state.npz")


def test_the_radius_is_that_of_the_pass_after_a_late_interruption(monkeypatch):
    """Ctrl-C right after the sums of a pass are kept; the next pass has the next radius."""
    passes = added(1)
    times = iter([0.0])
    with monkeypatch.context() as patched:
        patched.setattr("fastlines.beams.passes.time", SimpleNamespace(perf_counter=lambda: next(times)))
        with pytest.raises(StopIteration):
            passes.add()
    assert passes.done == 2
    passes.add()
    whole = added(3).picture()
    assert passes.picture().radius == whole.radius
    assert (passes.picture().radiance == whole.radiance).all()


def test_a_pass_that_is_interrupted_leaves_the_others():
    passes = added(1)
    before = passes.picture().radiance

    def stop(done):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        passes.add(stop)
    assert passes.done == 1
    assert (passes.picture().radiance == before).all()
    passes.add()
    assert (passes.picture().radiance == added(2).picture().radiance).all()


def test_pictures_do_not_depend_on_the_number_of_threads():
    pictures = []
    for n_threads in (1, 2):
        fl.set_num_threads(n_threads)
        try:
            pictures.append(render(example("mirrored-cube"), passes=1, **SMALL).radiance)
        finally:
            fl.set_num_threads(None)
    assert (pictures[0] == pictures[1]).all()


def test_progress_grows_to_the_end():
    told = []
    render(example("point-light"), passes=2, progress=told.append, **SMALL)
    assert told == sorted(told)
    assert told[-1] == 1
    assert any(0 < part < 0.5 for part in told)
    assert any(0.5 * TRACING < part < 0.5 for part in told)  # gathering


def test_pictures_of_both_files(tmp_path):
    exr = pytest.importorskip("OpenEXR")
    picture = render(example("glass-sphere"), passes=2, **SMALL)
    picture.save(tmp_path / "x.exr")
    with exr.File(str(tmp_path / "x.exr"), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    assert sorted(channels) == ["B", "G", "R", "samples", "variance.B", "variance.G", "variance.R"]
    for i, name in enumerate("RGB"):
        assert (channels[name] == picture.radiance[..., i]).all()
        assert (channels[f"variance.{name}"] == picture.variance[..., i]).all()
    assert (channels["samples"] == 2).all()
    assert channels["R"].dtype == np.float32
    picture.save(tmp_path / "x.png")
    assert picture.for_screen().to_bytes().shape == (9, 12, 3)
    assert picture.for_screen(-30).to_bytes().max() <= 1
    assert isinstance(picture._repr_png_(), bytes)


def test_a_dark_picture_has_an_exposure():
    dark = np.zeros((2, 3, 3), np.float32)
    assert BeamPicture(dark, dark, 1, 1, 0.1).for_screen().to_bytes().max() <= 1


def test_one_side_makes_a_square():
    scene = example("point-light")
    assert (Passes(scene, width=7).width, Passes(scene, width=7).height) == (7, 7)
    assert Passes(scene, PassSettings(n_paths=5), height=7).settings.size == (7, 7)
    assert Passes(scene, PassSettings(width=5), height=7).settings.size == (5, 7)
    assert Passes(scene).settings.size == (512, 512)


def test_a_camera_that_sees_no_medium_is_told_once():
    scene = example("point-light")
    away = fl.Camera(origin=(0, 0, 5), target=(0, 0, 10))
    passes = Passes(BeamScene(scene.medium, scene.lights, camera=away, box=scene.box), **SMALL)
    with pytest.warns(UserWarning, match="no ray of the camera goes through the medium"):
        passes.add()
    passes.add()
    assert not passes.picture().radiance.any()


def test_a_file_that_is_no_state_is_named(tmp_path):
    path = tmp_path / "own.png"
    added(1).picture().save(path)
    with pytest.raises(fl.InputError, match=r"own.png: is not the state of a picture; expected the .npz file"):
        Passes(example("glass-sphere"), **SMALL).resume(path)
