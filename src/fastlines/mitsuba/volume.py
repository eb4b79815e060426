"""A scene of Mitsuba as a scene of photon beams."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..beams.medium import Medium
from ..beams.scene import BeamScene
from ..support.counter_random import Float64Array
from .lights import MitsubaLights
from .medium import bounds_of, medium_of
from .packages import require_variant
from .surfaces import MitsubaSurfaces

#: How far a medium that no shape encloses is filled, in mean free paths beyond the shapes, lights and cameras.
MEAN_FREE_PATHS = 8.0
#: By how much a box is larger than the shapes that enclose a medium, as a fraction of its size.
MARGIN = 1e-3


def beam_scene(scene: Any) -> BeamScene:
    """Return a scene of Mitsuba as one that photons can be traced through.

    Its shapes, their BSDFs and its emitters stay Mitsuba's. The medium becomes one of ours.

    Parameters
    ----------
    scene : mitsuba.Scene
        As ``mitsuba.load_file`` and ``load_dict`` return it, with one medium.

    Returns
    -------
    fastlines.beams.BeamScene
        Without a camera.

    Raises
    ------
    InputError
        If Mitsuba's variant is not one that computes with arrays of RGB, the scene has not exactly one medium, its
        phase function is neither isotropic nor Henyey–Greenstein, or no emitter has power.

    Examples
    --------
    >>> import mitsuba  # doctest: +SKIP
    >>> mitsuba.set_variant("llvm_ad_rgb")  # doctest: +SKIP
    >>> scene = beam_scene(mitsuba.load_file("fog.xml"))  # doctest: +SKIP
    >>> fl.beams.trace_photons(scene, 100_000)  # doctest: +SKIP
    """
    require_variant()
    medium, enclosing = medium_of(scene)
    return BeamScene(medium, [MitsubaLights(scene)], MitsubaSurfaces(scene), box=_box(scene, medium, enclosing))


def _box(scene: Any, medium: Medium, enclosing: list[Any]) -> Float64Array:
    """Return a box around the medium."""
    if enclosing:
        box = bounds_of(enclosing)
        margin = MARGIN * (box[1] - box[0]).max()
    else:
        box = bounds_of([*scene.shapes(), *scene.emitters(), *scene.sensors()])
        margin = MEAN_FREE_PATHS / medium.extinction[medium.extinction > 0].min()
    return np.array([box[0] - margin, box[1] + margin])
