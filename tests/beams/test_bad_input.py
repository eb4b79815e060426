"""What cannot be used is refused in one sentence, which says what was expected."""

from __future__ import annotations

import re

import numpy as np
import pytest

import fastlines as fl
from fastlines.beams import (
    AreaLight,
    BeamMap,
    BeamPicture,
    BeamScene,
    DirectionalLight,
    Glass,
    GridMedium,
    HomogeneousMedium,
    Mirror,
    Passes,
    PointLight,
    SpotLight,
    example,
    render,
    single_scattering,
    trace_photons,
)

FOG, LIGHT, BOX = HomogeneousMedium(0, 1), PointLight((0, 0, 0), 1), [[-1, -1, -1], [1, 1, 1]]
NAN_GRID = np.full((2, 2, 2), np.nan)
SCENE = BeamScene(FOG, [LIGHT], box=BOX)
WITH_LENS = fl.Camera(origin=(0, 0, 4), target=(0, 0, 0), lens_radius=0.1)
BALL, WIRE = fl.Spheres.from_centres([[0.5, 0.5, 0.5]], radius=0.2), [[[0, 0, 0], [1, 0, 0]]]
CENTRED, IN_BALL = fl.Spheres.from_centres([[0, 0, 0]], radius=0.2), fl.Camera((0.4, 0.5, 0.5), (0, 0, 0))
CORNERS = np.array([[-1.0, -1, -1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]]) / 2
CUBE = fl.Triangles.from_mesh(CORNERS, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
MIRRORED = BeamScene(FOG, [LIGHT], [(BALL, Mirror())], box=BOX)
THICK = BeamScene(GridMedium(np.full((2, 2, 2), 1e18), BOX, 0, 1e18), [PointLight((0, 0, 0), 1e18)])
PICTURE = BeamPicture(np.ones((2, 2, 3), np.float32), np.ones((2, 2, 3), np.float32), 1, 1, 0.1)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: HomogeneousMedium(0, 0), "the medium has no extinction"),
        (lambda: HomogeneousMedium(1, 0), "the medium only absorbs light"),
        (lambda: HomogeneousMedium(-1, 1), "absorption=-1"),
        (lambda: HomogeneousMedium((1, 2), 1), r"absorption=\(1, 2\)"),
        (lambda: HomogeneousMedium(0, np.inf), "scattering=inf"),
        (lambda: HomogeneousMedium(0, 1e30), "scattering=1e.30; expected .* from 0 to 1e.18"),
        (
            lambda: BeamScene(HomogeneousMedium(0, 1e17), [LIGHT], box=BOX),
            "scattering=.* expected a sum of at most 5e.08",
        ),
        (lambda: GridMedium(np.full((2, 2, 2), 1e30), BOX, 0, 1), "density is from 1e.30 to 1e.30"),
        (lambda: HomogeneousMedium("a", 1), "absorption"),
        (lambda: HomogeneousMedium(0, 1, g=1), "g=1"),
        (lambda: GridMedium(NAN_GRID, BOX, 0, 1), "density holds NaN or Inf in 8 of 8 voxels"),
        (lambda: GridMedium(np.zeros((2, 2, 2)), BOX, 0, 1), "density is from 0 to 0"),
        (lambda: GridMedium(-np.ones((2, 2, 2)), BOX, 0, 1), "density is from -1 to -1"),
        (lambda: GridMedium(np.ones((2, 2)), BOX, 0, 1), r"density has shape \(2, 2\)"),
        (lambda: GridMedium(np.ones((2, 2, 2)), [[0, 0, 0], [1, 1, 0]], 0, 1), "box="),
        (lambda: PointLight((0, 0, 0), 0), "the light has no power"),
        (lambda: PointLight((0, 0, 0), 1e39), "power=1e.39; expected .* from 0 to 1e.18"),
        (lambda: BeamMap(THICK, trace_photons(THICK, 10)), "the power of the lights, .* times the scattering"),
        (lambda: PointLight((0, 0), 1), r"position=\(0, 0\)"),
        (lambda: SpotLight((0, 0, 0), (0, 0, 0), 1), "position and target are both"),
        (lambda: SpotLight((0, 0, 0), (0, 0, 1), 1, 0), "angle_degrees=0"),
        (lambda: AreaLight((0, 0, 0), (1, 0, 0), (2, 0, 0), 1), "span no area"),
        (lambda: DirectionalLight((0, 0, 0), 1), "direction=.* has no length"),
        (lambda: DirectionalLight((0, 0, 1), (0, 0, 0)), "the light has no power"),
        (lambda: Mirror(1.5), "reflectance=1.5"),
        (lambda: Glass(0), "ior=0"),
        (lambda: BeamScene(FOG, [], box=BOX), "there are no lights; give one"),
        (lambda: BeamScene(FOG, [LIGHT, FOG], box=BOX), "light 1 is a HomogeneousMedium; expected a light"),
        (lambda: BeamScene(FOG, [PointLight], box=BOX), "light 0 is a class, PointLight; expected a light"),
        (lambda: BeamScene("fog", [LIGHT], box=BOX), "medium is a str"),
        (lambda: BeamScene(HomogeneousMedium, [LIGHT], box=BOX), "medium is a class, HomogeneousMedium"),
        (lambda: BeamScene(FOG, [LIGHT]), "nothing says where the medium is"),
        (lambda: BeamScene(FOG, [LIGHT], box=[[1, 1, 1], [0, 0, 0]]), "its lowest and highest corner"),
        (lambda: BeamScene(FOG, [LIGHT], [Mirror()], box=BOX), "surface 0 is a Mirror; expected a pair"),
        (lambda: BeamScene(FOG, [LIGHT], Mirror(), box=BOX), "surfaces are a Mirror; expected a list of pairs"),
        (lambda: BeamScene(FOG, [LIGHT], [(BALL, Glass)], box=BOX), "the material of surface 0 is a class, Glass"),
        (lambda: BeamScene(FOG, [LIGHT], [(BALL, LIGHT)], box=BOX), "the material of surface 0 is a PointLight"),
        (
            lambda: BeamScene(FOG, [LIGHT], [(BALL, Glass()), (fl.Lines.from_segments(WIRE), Glass())], box=BOX),
            "the geometry of surface 1 is Lines; expected Triangles, Spheres or Boxes",
        ),
        (lambda: BeamScene(FOG, [LIGHT], [(fl.Spheres, Glass())], box=BOX), "surface 0 is a class, Spheres"),
        (lambda: BeamScene(FOG, [LIGHT], [(fl.Geometry([BALL]), Glass())], box=BOX), "surface 0 is a Geometry"),
        (lambda: BeamScene(FOG, [LIGHT], [("ball", Glass())], box=BOX), "the geometry of surface 0 is a str"),
        (
            lambda: BeamScene(FOG, [LIGHT], [(fl.Triangles(np.zeros((0, 3, 3))), Mirror())], box=BOX),
            "surface 0 has no primitives",
        ),
        (
            lambda: BeamScene(FOG, [LIGHT], [(BALL, Glass()), (fl.Boxes([BOX]), Glass(1.3))]),
            "surface 0 is inside of surface 1, and both are of Glass",
        ),
        (
            lambda: BeamScene(GridMedium(np.ones((2, 2, 2)), BOX, 0, 1), [LIGHT], box=[[2, 2, 2], [3, 3, 3]]),
            r"box=\[\[2.0, 2.0, 2.0\], .* and that of the medium, .* do not overlap",
        ),
        (lambda: BeamScene(FOG, [LIGHT], [(CENTRED, Glass())], box=BOX), "light 0 is inside of surface 0, .* of Glass"),
        (lambda: BeamScene(FOG, [LIGHT], [(CUBE, Glass())], box=BOX), "light 0 is inside of surface 0, .* of Glass"),
        (
            lambda: BeamScene(FOG, [LIGHT], [(BALL, Mirror()), (BALL, Glass())], IN_BALL, box=BOX),
            "the camera is inside of surface 1, which is of Glass; expected lights and the camera outside of glass",
        ),
        (lambda: BeamScene(FOG, [LIGHT], camera=1, box=BOX), "camera is an int"),
        (lambda: BeamScene(FOG, [LIGHT], camera=WITH_LENS, box=BOX), "has a lens; expected a pinhole"),
        (lambda: example("glas-sphere"), "there is no scene .glas-sphere.; did you mean .glass-sphere."),
        (lambda: trace_photons(SCENE, 0), "n_paths=0"),
        (lambda: trace_photons(SCENE, 1, kind="medium"), "kind='medium'"),
        (lambda: trace_photons(SCENE, 1, seed=-1), "seed=-1"),
        (lambda: trace_photons(SCENE, 1, max_scatterings=-1), "max_scatterings=-1"),
        (
            lambda: trace_photons(BeamScene(FOG, [SpotLight((5, 0, 0), (6, 0, 0), 1)], box=BOX), 50),
            "none of 50 photons flies through the medium",
        ),
        (lambda: Passes(SCENE), "the scene has no camera"),
        (lambda: Passes(example("point-light")).picture(), "there is no pass yet"),
        (lambda: render(example("point-light"), radius=0), "radius=0"),
        (lambda: render(example("point-light"), radius=np.nan), "radius=nan"),
        (lambda: render(example("point-light"), radius=1e-30), "radius=1e-30; expected .* from 2e-07 to 2e.06"),
        (lambda: render("glass-sphere"), "scene is a str; expected a BeamScene, such as fl.beams.example"),
        (lambda: trace_photons("fog", 1), "scene is a str"),
        (lambda: PICTURE.for_screen(np.nan), "exposure=nan; expected a power of 2"),
        (lambda: PICTURE.save("x.exr", 1.0), "exposure=1.0 does not apply: an .exr holds the radiance itself"),
        (lambda: render(example("point-light"), alpha=0), "alpha=0"),
        (lambda: render(example("point-light"), passes=0), "passes=0"),
        (lambda: render(example("point-light"), width=0), "width=0"),
        (lambda: render(example("point-light"), widht=8), "there is no setting 'widht'; did you mean 'width'"),
        (lambda: Passes(example("point-light"), foo=1), "there is no setting 'foo'; known: width, height"),
        (lambda: render(example("point-light"), kind="wide"), "kind='wide'"),
        (lambda: render(example("point-light"), blur="none"), "blur='none'"),
        (lambda: render(example("point-light"), estimator="line"), "estimator='line'"),
        (lambda: single_scattering(example("glass-sphere"), [0, 0, 0], [0, 0, 1]), "for one PointLight"),
        (lambda: single_scattering(MIRRORED, [0.1, 0, -3], [0, 0, 1]), "in a scene without surfaces"),
        (
            lambda: single_scattering(BeamScene(FOG, [PointLight((2, 0, 0), 1)], box=BOX), [0, 0, -3], [0, 0, 1]),
            r"the light at \(2.0, 0.0, 0.0\) is outside of the box",
        ),
        (
            lambda: single_scattering(SCENE, [[0.1, 0, -3], [0.3, 0.6, 0.9]], [[0, 0, 1], [1, 2, 3]]),
            "1 of 2 rays lie on a line through the light .*1",
        ),
        (lambda: single_scattering(SCENE, [0, 0, 0], [0, 0, 0]), "1 of 1 rays are not finite, or have no direction"),
        (lambda: single_scattering(SCENE, [0, 0], [0, 0, 1]), r"shapes \(2,\) and \(3,\)"),
        (
            lambda: BeamMap(SCENE, trace_photons(SCENE, 10)).radiance([0, 0, -3], [0, 0, 1], 0),
            "radius=0; expected the radius of the blur",
        ),
        (lambda: BeamMap(SCENE, trace_photons(SCENE, 10)).radiance([0, 0, -3], [0, 0, 1]), "radius=None"),
        (
            lambda: BeamMap(SCENE, trace_photons(SCENE, 10)).radiance(np.zeros((3, 3)), np.ones((2, 3)), 0.1),
            r"origins and directions have shapes \(3, 3\) and \(2, 3\); expected \(n, 3\) each",
        ),
        (lambda: BeamMap(SCENE, trace_photons(SCENE, 10), own_radius=0), "own_radius=0"),
        (lambda: render(example("point-light"), adapt=True, estimator="point"), "without a radius of their own"),
    ],
)
def test_bad_input_is_refused(make, message):
    with pytest.raises(fl.InputError, match=message) as raised:
        make()
    assert re.fullmatch(r"[^\n]+", str(raised.value))


def test_lights_and_cameras_beside_glass_are_taken():
    lights = [PointLight((0.9, 0, 0), 1), DirectionalLight((0, 1, 0), 1)]
    camera = fl.Camera((0, 0, 5), (0, 0, 0))
    scene = BeamScene(FOG, lights, [(CENTRED, Mirror()), (CUBE, Glass()), (BALL, Mirror())], camera, box=BOX)
    assert scene.surfaces.encloses(1, [[0, 0, 0], [0.5, 0.5, -0.5], [0.9, 0, 0]]).tolist() == [True, False, False]
    assert BeamScene(FOG, [LIGHT], [(CENTRED, Mirror())], box=BOX).surfaces.glass == []
