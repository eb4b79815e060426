"""Former public names: they work for one more release, with a DeprecationWarning."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

from .refit import RebuildPolicy
from .splits import FORMER_FIELDS, BinnedPlanes, Midpoint


def former(name: str) -> Any:
    """Return what a former name of the package stands for, with a warning; None if there was no such name."""
    made: dict[str, tuple[Callable[..., Any], type]] = {
        "Middle": (Midpoint, Midpoint),
        "PlaneOctets": (_plane_octets, BinnedPlanes),
        "RebuildRule": (RebuildPolicy, RebuildPolicy),
    }
    if name not in made:
        return None
    meant, now = made[name]
    warnings.warn(f"fl.{name} is now fl.{now.__name__}", DeprecationWarning, stacklevel=3)
    return meant


def _plane_octets(*values: Any, **fields: Any) -> BinnedPlanes:
    """Make `BinnedPlanes` of the former parameters."""
    return BinnedPlanes(*values, **{FORMER_FIELDS.get(name, name): value for name, value in fields.items()})
