"""All lights of a scene of Mitsuba, as one of ours."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..beams.lights import Emission
from ..camera import Vector
from ..errors import InputError
from ..support.computed_once import computed_once
from ..support.counter_random import Float64Array, UInt64Array, random_bits
from .conversion import flags, pairs_of_samples, samples, triples, unit_triples
from .packages import dr

#: How many photons estimate the power of all lights together.
POWER_SAMPLES = 1 << 14


class MitsubaLights:
    """All lights of a scene of Mitsuba, as one `beams.Light`.

    Parameters
    ----------
    scene : mitsuba.Scene

    Raises
    ------
    InputError
        If the scene has no lights, or none that has power.
    """

    def __init__(self, scene: Any) -> None:
        self.scene = scene
        if not scene.emitters():
            raise InputError('the scene has no emitters; add one, such as <emitter type="point">')
        if not any(self._power):
            raise InputError("the emitters of the scene have no power; give one an intensity or radiance above 0")

    @computed_once
    def _power(self) -> Vector:
        emission = self.emit(random_bits(0, np.arange(POWER_SAMPLES)), np.zeros((2, 3)))
        red, green, blue = emission.power.mean(axis=0).tolist()
        return red, green, blue

    def total_power(self, bounds: Float64Array) -> Vector:
        """See `beams.Light`; an estimate, which chooses between lights and does not scale them."""
        return self._power

    def emit(self, keys: UInt64Array, bounds: Float64Array) -> Emission:
        """See `beams.Light`; Mitsuba knows the bounds of its scene."""
        n = len(keys)
        ray, weight, emitter = self.scene.sample_emitter_ray(
            0.0, samples(keys, 0), pairs_of_samples(keys, 1), pairs_of_samples(keys, 3), True
        )
        # Light of a shape starts outside of it; other lights say where they are.
        shape = emitter.get_shape()
        around = dr.select(shape != None, shape.exterior_medium(), emitter.get_medium())  # noqa: E711
        in_medium = around != None  # noqa: E711
        dr.eval(ray, weight, in_medium)  # in one kernel
        return Emission(triples(ray.o, n), unit_triples(ray.d, n), triples(weight, n), flags(in_medium, n))

    def fingerprint(self) -> str:
        """Return a text for unfinished pictures; the surfaces of the scene tell scenes apart."""
        return "all emitters"
