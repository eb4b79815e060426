"""Pictures of light in media."""

from __future__ import annotations

from typing import Any

from ..arrays import count
from ..progress import ProgressOption, reporting, staged
from .beam_picture import BeamPicture
from .passes import Passes
from .scene import BeamScene

#: How many passes a picture has by default.
PASSES = 16


def render(scene: BeamScene, *, passes: int = PASSES, progress: ProgressOption = False, **settings: Any) -> BeamPicture:
    """Render the light that the medium of a scene scatters into its camera.

    Parameters
    ----------
    scene : BeamScene
        With a camera.
    passes : int
        How many passes to average, each of new photons and of one ray a pixel. `Passes` adds them one by one.
    progress : bool or callable
        Show a bar, or call back with the fraction that is done.
    **settings
        The fields of `PassSettings`: width, height, n_paths, radius, alpha, kind, adapt, blur, estimator,
        points, max_scatterings, seed, method.

    Returns
    -------
    BeamPicture

    Raises
    ------
    InputError
        If the scene has no camera, no photon flies through the medium, or a setting cannot be used.

    Examples
    --------
    >>> import fastlines as fl
    >>> fl.beams.render(fl.beams.example("glass-sphere"), width=32, height=32, passes=2, n_paths=2000)
    <BeamPicture: 32 × 32 pixels, 2 passes>
    """
    made = Passes(scene, **settings)
    count("passes", passes, 1)
    with reporting(progress, "render") as callback:
        for i in range(passes):
            made.add(staged(callback, i / passes, (i + 1) / passes))
    return made.picture()
