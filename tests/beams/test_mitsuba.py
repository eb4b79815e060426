"""Photon beams in scenes of Mitsuba. All tests need Mitsuba and a variant of it that runs by LLVM."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import numpy as np
import pytest

import fastlines as fl

mi = pytest.importorskip("mitsuba", minversion="3.7")

from fastlines.mitsuba import beam_scene  # noqa: E402
from fastlines.mitsuba.integrator import NAME  # noqa: E402
from fastlines.mitsuba.lights import MitsubaLights  # noqa: E402
from fastlines.mitsuba.medium import medium_of  # noqa: E402
from fastlines.mitsuba.packages import require_variant  # noqa: E402
from fastlines.mitsuba.surfaces import MitsubaSurfaces  # noqa: E402
from fastlines.support.counter_random import random_bits  # noqa: E402

FOG = {"type": "ref", "id": "fog"}
KEYS = random_bits(0, np.arange(4000))


@pytest.fixture(autouse=True)
def _variant() -> None:
    try:
        mi.set_variant("llvm_ad_rgb")
        require_variant()
    except (ImportError, RuntimeError, fl.InputError) as error:
        pytest.skip(f"Mitsuba's variant does not run here: {error}")
    mi.set_log_level(mi.LogLevel.Error)


def load(**parts: Any) -> Any:
    """Return a scene of fog in a cube, lit by a point, with more parts or others."""
    fog = {
        "type": "homogeneous",
        "sigma_t": {"type": "rgb", "value": [0.5, 0.6, 0.7]},
        "albedo": 0.8,
        "phase": {"type": "hg", "g": 0.4},
    }
    scene = {
        "type": "scene",
        "fog": fog,
        "cube": {"type": "cube", "bsdf": {"type": "null"}, "interior": FOG},
        "light": {"type": "point", "position": [0.4, 0.8, 0.3], "intensity": 10.0, "medium": FOG},
    }
    return mi.load_dict({name: part for name, part in (scene | parts).items() if part is not None})


def sensor(spp: int) -> dict[str, Any]:
    """Return a camera that sees the fog below the light, in few pixels."""
    film = {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}}
    to_world = mi.ScalarTransform4f().look_at(origin=[0, 0, 4], target=[0, -0.4, 0], up=[0, 1, 0])
    sampler = {"type": "independent", "sample_count": spp}
    return {"type": "perspective", "fov": 12, "to_world": to_world, "film": film, "sampler": sampler}


def test_the_medium_has_the_same_coefficients() -> None:
    medium, enclosing = medium_of(load())
    assert isinstance(medium, fl.beams.HomogeneousMedium)
    assert medium.scattering == pytest.approx([0.4, 0.48, 0.56], rel=1e-6)
    assert medium.extinction == pytest.approx([0.5, 0.6, 0.7], rel=1e-6)
    assert medium.g == pytest.approx(0.4)
    assert [shape.id() for shape in enclosing] == ["cube"]


def test_a_grid_keeps_its_voxels() -> None:
    density = np.random.default_rng(1).random((4, 3, 2)).astype(np.float32)
    grid = mi.VolumeGrid(np.ascontiguousarray(density.transpose(2, 1, 0)))
    place = mi.ScalarTransform4f().translate([-1, -1, -1]).scale(2)
    sigma_t = {"type": "gridvolume", "grid": grid, "to_world": place, "filter_type": "trilinear"}
    smoke = {"type": "heterogeneous", "sigma_t": sigma_t, "albedo": 0.25, "scale": 3.0}
    medium, _ = medium_of(load(fog=smoke))
    assert isinstance(medium, fl.beams.GridMedium)
    assert np.abs(medium.density * medium.extinction[0] - 3 * density).max() < 1e-5
    assert np.array(medium.scattering) / medium.extinction == pytest.approx([0.25] * 3, rel=1e-5)
    assert medium.box.tolist() == [[-1, -1, -1], [1, 1, 1]]
    assert medium.g == 0


def test_a_grid_smaller_than_its_shape_ends_where_it_ends() -> None:
    grid = mi.VolumeGrid(np.ones((4, 4, 4), np.float32))
    place = mi.ScalarTransform4f().translate([-0.5, -0.5, -0.5])
    smoke = {"type": "heterogeneous", "sigma_t": {"type": "gridvolume", "grid": grid, "to_world": place}}
    medium, _ = medium_of(load(fog=smoke))
    assert isinstance(medium, fl.beams.GridMedium)
    assert medium.density.sum() == medium.density[1:3, 1:3, 1:3].sum() == 8


def test_a_colour_that_varies_is_refused() -> None:
    albedo = {"type": "gridvolume", "grid": mi.VolumeGrid(np.linspace(0, 1, 8, dtype=np.float32).reshape(2, 2, 2))}
    with pytest.raises(fl.InputError, match="the colour of the medium's scattering varies from place to place"):
        medium_of(load(fog={"type": "homogeneous", "albedo": albedo}))


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"cube": None, "light": {"type": "point"}, "fog": None}, "the scene has 0 media; .*: give one medium an id"),
        ({"more": {"type": "sphere", "interior": {"type": "homogeneous"}}}, "the scene has 2 media"),
        ({"fog": {"type": "homogeneous", "phase": {"type": "rayleigh"}}}, "RayleighPhaseFunction; expected isotropic"),
        ({"light": None}, "the scene has no emitters; add one"),
        ({"light": {"type": "point", "intensity": 0.0}}, "the emitters of the scene have no power"),
    ],
)
def test_scenes_that_cannot_be_drawn(parts: dict[str, Any], message: str) -> None:
    with pytest.raises(fl.InputError, match=message):
        beam_scene(load(**parts))


def test_a_medium_without_a_shape_around_it_goes_on() -> None:
    ball = {"type": "sphere", "radius": 0.4, "exterior": FOG}
    box = beam_scene(load(cube=None, ball=ball)).box
    assert box.tolist() == pytest.approx(np.array([[-16.4, -16.4, -16.4], [16.4, 16.8, 16.4]]))
    assert np.abs(beam_scene(load(ball=ball)).box).max() == pytest.approx(1, abs=0.01)


def test_lights_emit_their_power_where_they_are() -> None:
    ball = {"type": "sphere", "radius": 0.5, "emitter": {"type": "area", "radiance": 2.0}, "exterior": FOG}
    point = MitsubaLights(load()).emit(KEYS, np.zeros((2, 3)))
    area = MitsubaLights(load(light=ball)).emit(KEYS, np.zeros((2, 3)))
    assert point.power == pytest.approx(np.full((4000, 3), 40 * np.pi))
    assert area.power == pytest.approx(np.full((4000, 3), 2 * np.pi * np.pi), rel=1e-5)
    assert np.hypot.reduce(area.origins, axis=1) == pytest.approx(np.full(4000, 0.5), rel=1e-3)
    assert point.in_medium.all()
    assert area.in_medium.all()
    assert not MitsubaLights(load(light={"type": "point"})).emit(KEYS, np.zeros((2, 3))).in_medium.any()


def test_photons_pass_boundaries_and_are_refracted() -> None:
    glass = {"type": "sphere", "radius": 0.5, "bsdf": {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}}
    surfaces = MitsubaSurfaces(load(glass=glass | {"exterior": FOG}))
    origins, directions = np.array([[0.3, 0, 4.0], [0.3, 0, 0.9], [2, 0, 4]]), np.array([[0, 0, -1.0]] * 3)
    hits = surfaces.intersect(origins, directions)
    assert hits.t.tolist() == pytest.approx([3, 0.5, np.inf])

    boundary = hits.scatter(np.zeros(1, int), np.zeros(1, bool), KEYS[:1])
    assert boundary.directions.tolist() == [[0, 0, -1]]
    assert boundary.weight.tolist() == [[1, 1, 1]]
    assert boundary.in_medium.all()
    assert boundary.is_specular.all()

    many = hits.scatter(np.ones(len(KEYS), int), np.ones(len(KEYS), bool), KEYS)
    passes = ~many.in_medium
    sine = np.hypot(*many.directions[passes].T[:2])
    turned = np.arcsin(0.6) - np.arcsin(0.4)
    assert sine == pytest.approx(np.full(len(sine), np.sin(turned)), abs=1e-4)
    # Fresnel's equations reflect 4.6 % of unpolarised light that comes at this angle.
    assert (~passes).mean() == pytest.approx(0.046, abs=3 * np.sqrt(0.046 / len(KEYS)))


def test_energy_is_kept_and_batches_do_not_matter() -> None:
    scene = beam_scene(load(ball={"type": "sphere", "radius": 0.4, "bsdf": {"type": "diffuse"}, "exterior": FOG}))
    whole, parts = (fl.beams.trace_photons(scene, 3000, batch=batch) for batch in (3000, 700))
    energy = whole.energy
    assert energy.emitted == pytest.approx(np.full(3, 40 * np.pi))
    rest = energy.absorbed_by_medium + energy.absorbed_by_surfaces + energy.escaped + energy.cut_off
    assert rest == pytest.approx(energy.emitted)
    assert np.array_equal(whole.lines.segments, parts.lines.segments)
    assert np.array_equal(whole.power, parts.power)


#: What fills the cube and lights it, for comparisons with Mitsuba's `volpath`.
SCENES = {
    "fog": {},
    "diffuse": {"ball": {"type": "sphere", "center": [0, -0.5, 0], "radius": 0.3, "exterior": FOG}},
    "glass": {
        "ball": {
            "type": "sphere",
            "center": [0, -0.2, 0.2],
            "radius": 0.25,
            "bsdf": {"type": "dielectric"},
            "exterior": FOG,
        },
        # A sphere, as paths that are traced from the camera hit no point.
        "light": {
            "type": "sphere",
            "center": [0.2, 0.6, 0.2],
            "radius": 0.2,
            "emitter": {"type": "area", "radiance": 10.0},
            "exterior": FOG,
        },
    },
}


@pytest.mark.parametrize(("name", "single"), [("fog", True), ("fog", False), ("diffuse", False), ("glass", False)])
def test_pictures_are_those_of_volpath(name: str, single: bool) -> None:
    """The mean of a picture agrees within 3 standard errors, and half a percent for the blur."""
    ours = {"type": NAME, "n_paths": 10_000, "passes": 1, "radius": 0.03, "adapt": single, "max_depth": -1}
    theirs = {"type": "volpath", "max_depth": -1}
    if single:
        ours["max_scatterings"], theirs["max_depth"] = 0, 2

    def means(integrator: dict[str, Any], spp: int) -> np.ndarray:
        scene = load(**SCENES[name], integrator=integrator, sensor=sensor(spp))
        return np.array([np.mean(mi.render(scene, seed=seed)) for seed in range(8)])

    found, expected = means(ours, 64), means(theirs, 512)
    error = np.sqrt((found.var(ddof=1) + expected.var(ddof=1)) / 8)
    assert error < 0.05 * expected.mean()
    assert abs(found.mean() - expected.mean()) < 3 * error + 0.005 * expected.mean()


def test_a_scene_file_names_the_integrator() -> None:
    scene = mi.load_string(
        """<scene version="3.0.0">
            <integrator type="photonbeams">
                <integer name="n_paths" value="2000"/> <integer name="passes" value="2"/>
                <float name="radius" value="0.05"/> <string name="kind" value="long"/>
            </integrator>
            <medium type="homogeneous" id="fog"/>
            <shape type="cube"><bsdf type="null"/><ref name="interior" id="fog"/></shape>
            <emitter type="point"><ref id="fog"/></emitter>
            <sensor type="perspective">
                <transform name="to_world"><lookat origin="0, 0, 6" target="0, 0, 0" up="0, 1, 0"/></transform>
                <sampler type="independent"><integer name="sample_count" value="3"/></sampler>
                <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="8"/></film>
            </sensor>
        </scene>"""
    )
    first, again, other = (np.array(mi.render(scene, seed=seed)) for seed in (0, 0, 1))
    assert first.shape == (8, 12, 3)
    assert first[4, 6].min() > first[4, 2].min() > 0
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    assert scene.sensors()[0].sampler().sample_count() == 3


def test_rays_in_parts_make_the_same_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    """More calls of Mitsuba take other samples of the same beams, so their mean is nearly the same."""
    scene = load(sensor=sensor(16), integrator={"type": NAME, "n_paths": 3000, "passes": 1, "radius": 0.05})
    whole = np.array(mi.render(scene))
    monkeypatch.setattr("fastlines.mitsuba.integrator.RAYS", 5 * 64)
    parts = np.array(mi.render(scene))
    assert not np.array_equal(whole, parts)
    assert parts.mean() == pytest.approx(whole.mean(), rel=0.02)


def test_a_missing_mitsuba_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    monkeypatch.delitem(sys.modules, "fastlines.mitsuba.packages")
    with pytest.raises(fl.MissingExtraError, match=r"fastlines.mitsuba needs the extra 'mitsuba': run  pip install"):
        importlib.import_module("fastlines.mitsuba.packages")


def test_max_depth_bounds_the_bounces_at_surfaces() -> None:
    """The camera sees the fog through a boundary and a mirror; without bounces it sees the fog before the mirror."""
    mirror = {"type": "rectangle", "bsdf": {"type": "conductor", "material": "none"}, "exterior": FOG, "interior": FOG}
    means = [
        np.mean(mi.render(load(sensor=sensor(4), mirror=mirror, integrator=options | {"max_depth": depth})))
        for options in [{"type": NAME, "n_paths": 3000, "passes": 1, "radius": 0.05, "max_scatterings": 0}]
        for depth in (0, 1, 2)
    ]
    assert means[1] == means[2] > 1.2 * means[0] > 0


def test_hidden_emitters_are_looked_through() -> None:
    ball = {"type": "sphere", "radius": 0.5, "emitter": {"type": "area", "radiance": 50.0}, "exterior": FOG}
    options = {"type": NAME, "n_paths": 1000, "passes": 1}
    shown, hidden = (
        np.mean(mi.render(load(light=ball, sensor=sensor(4), integrator=options | {"hide_emitters": hide})))
        for hide in (False, True)
    )
    assert hidden < shown / 5


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"radius": -1.0}, "radius=-1.0; expected the radius of the blur"),
        ({"n_paths": 0}, "n_paths=0; expected a whole number"),
        ({"passes": 0}, "passes=0; expected a whole number"),
        ({"max_depth": -2}, "max_depth=-2; expected a whole number"),
        ({"kind": "wide"}, "kind='wide' is not a choice"),
        ({"width": 3}, "unreferenced property"),
    ],
)
def test_parameters_that_cannot_be_used(parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(RuntimeError, match=message):
        mi.load_dict({"type": NAME} | parameters)


@pytest.mark.parametrize("variant", ["scalar_rgb", "llvm_ad_spectral"])
def test_other_variants_are_refused(variant: str) -> None:
    if variant not in mi.variants():
        pytest.skip("Mitsuba has no such variant here")
    mi.set_variant(variant)
    with pytest.raises(RuntimeError, match=f"the variant of Mitsuba is '{variant}'.*set_variant\\('llvm_ad_rgb'\\)"):
        mi.load_dict({"type": NAME})


def test_an_llvm_that_would_end_the_process_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.import_module("drjit").detail, "llvm_version", lambda: (15, 0, 6))
    with pytest.raises(fl.InputError, match=r"LLVM 15\.0\.6, which ends the process.*install LLVM 17 or later"):
        require_variant()
