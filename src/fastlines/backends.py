"""Backends that answer about any geometry: curves and primitives of your own wrap the answers of the core."""

from __future__ import annotations

from .backend import Backend
from .curve_backend import CurveBackend, has_curves
from .curves import Curves
from .custom import Custom
from .custom_backend import CustomBackend
from .geometry import AnyGeometry, Geometry


def backend_of(geometry: AnyGeometry, core: Backend | None) -> Backend:
    """Return the backend for a geometry, from that of its rows in the core; None is brute force on your own class."""
    if isinstance(geometry, Custom):
        return CustomBackend(geometry, core)
    assert core is not None
    if has_curves(geometry):
        assert isinstance(geometry, Curves | Geometry)
        return CurveBackend(core, geometry)
    return core
