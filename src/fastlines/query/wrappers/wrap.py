"""Backends for any geometry and rays: they wrap the answers of the core for curves, your own class, and `ignore`."""

from __future__ import annotations

from typing import cast

from ...geometry.any_geometry import AnyGeometry
from ...geometry.user_primitives import UserPrimitives
from ..backend import Backend
from ..rays import RayBatch
from .curves import CurveBackend
from .ignore import IgnoringBackend
from .nearest import NearestBackend
from .pieces import Pieces, View
from .user_primitives import UserBackend


def backend_of(
    geometry: AnyGeometry, core: Backend | None, view: View | None, rays: RayBatch, *, is_tree: bool = True
) -> Backend:
    """Return the backend for a geometry and rays, from that of its rows in the core: None for brute force."""
    found: Backend
    if geometry.has_user_code:
        found = UserBackend(cast(UserPrimitives, geometry), core)
    else:
        assert core is not None
        assert view is not None
        pieces = Pieces(core, geometry, view)
        found = CurveBackend(pieces) if geometry.in_pieces else core
        # Brute force tests all pairs, whatever the radius is.
        found = NearestBackend(found, pieces) if is_tree else found
    return IgnoringBackend(found, geometry) if rays.ignored else found
