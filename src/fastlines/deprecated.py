"""Former public names: they work for one more release, with a DeprecationWarning."""

from __future__ import annotations

import warnings
from typing import Any

from .refit import RebuildPolicy
from .splits import FORMER_FIELDS, BinnedPlanes, Midpoint

#: Former names, and the classes that they refer to.
FORMER: dict[str, type] = {"Middle": Midpoint, "PlaneOctets": BinnedPlanes, "RebuildRule": RebuildPolicy}


def former(name: str) -> Any:
    """Return the object that a former name of the package refers to, with a warning; None for other names."""
    if name not in FORMER:
        return None
    warnings.warn(f"fl.{name} is now fl.{FORMER[name].__name__}", DeprecationWarning, stacklevel=3)
    return _plane_octets if name == "PlaneOctets" else FORMER[name]


def _plane_octets(*values: Any, **fields: Any) -> BinnedPlanes:
    """Make `BinnedPlanes` of the former parameters."""
    return BinnedPlanes(*values, **{FORMER_FIELDS.get(name, name): value for name, value in fields.items()})
