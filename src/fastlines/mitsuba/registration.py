"""Tells Mitsuba of the integrator, whichever variant is current and will be."""

from __future__ import annotations

from .integrator import NAME, make
from .packages import mi


def register() -> None:
    """Register the integrator for the current variant of Mitsuba, and for each that is set later."""
    mi.detail.add_variant_callback(_register)
    if mi.variant() is not None:
        _register()


def _register(*_: object) -> None:
    mi.register_integrator(NAME, make)
