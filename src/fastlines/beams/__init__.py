"""Photon beams: light in fog, smoke and water, from the flights of photons (Jarosz et al. 2011)."""

from .beam_picture import BeamPicture
from .estimate import BeamMap
from .examples import NAMES, example
from .grid_medium import GridMedium
from .lights import AreaLight, DirectionalLight, PointLight, SpotLight
from .materials import Diffuse, Glass, Mirror
from .medium import HomogeneousMedium
from .passes import Passes, PassSettings
from .photons import Beams, Energy, trace_photons
from .render import render
from .scene import BeamScene
from .single_scattering import single_scattering
from .surfaces import TracedSurfaces

__all__ = [
    "NAMES",
    "AreaLight",
    "BeamMap",
    "BeamPicture",
    "BeamScene",
    "Beams",
    "Diffuse",
    "DirectionalLight",
    "Energy",
    "Glass",
    "GridMedium",
    "HomogeneousMedium",
    "Mirror",
    "PassSettings",
    "Passes",
    "PointLight",
    "SpotLight",
    "TracedSurfaces",
    "example",
    "render",
    "single_scattering",
    "trace_photons",
]
