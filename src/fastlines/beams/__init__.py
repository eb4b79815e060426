"""Photon beams: light in fog, smoke and water, from the flights of photons (Jarosz et al. 2011)."""

from .grid_medium import GridMedium
from .lights import AreaLight, DirectionalLight, PointLight, SpotLight
from .materials import Diffuse, Glass, Mirror
from .medium import HomogeneousMedium
from .photons import Beams, Energy, trace_photons
from .scene import BeamScene
from .surfaces import TracedSurfaces

__all__ = [
    "AreaLight",
    "BeamScene",
    "Beams",
    "Diffuse",
    "DirectionalLight",
    "Energy",
    "Glass",
    "GridMedium",
    "HomogeneousMedium",
    "Mirror",
    "PointLight",
    "SpotLight",
    "TracedSurfaces",
    "trace_photons",
]
