"""Backends for any geometry and rays: they wrap the answers of the core for curves, your own class, and `ignore`."""

from __future__ import annotations

from .backend import Backend
from .curve_backend import CurveBackend, has_curves
from .curves import Curves
from .custom import Custom
from .custom_backend import CustomBackend
from .geometry import AnyGeometry, Geometry
from .ignore_backend import IgnoringBackend
from .rays import RayBatch


def backend_of(geometry: AnyGeometry, core: Backend | None, rays: RayBatch) -> Backend:
    """Return the backend for a geometry and rays, from that of its rows in the core: None for brute force."""
    found: Backend
    if isinstance(geometry, Custom):
        found = CustomBackend(geometry, core)
    else:
        assert core is not None
        found = core
        if has_curves(geometry):
            assert isinstance(geometry, Curves | Geometry)
            found = CurveBackend(core, geometry)
    return IgnoringBackend(found) if rays.ignored else found
