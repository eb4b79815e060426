"""Photon beams in scenes of Mitsuba 3.

Importing this package adds the integrator ``photonbeams`` to Mitsuba, for files of scenes and for dictionaries.
`beam_scene` makes a scene of Mitsuba one of `fastlines.beams`.
"""

from .registration import register
from .volume import beam_scene

__all__ = ["beam_scene"]

register()
