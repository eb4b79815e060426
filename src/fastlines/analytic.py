"""The former name of `fastlines.theory.hits`."""

from .theory.hits import capsule_interval, closest_approach

__all__ = ["capsule_interval", "closest_approach"]
