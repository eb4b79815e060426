"""The table of the kinds of geometry that files keep; `Geometry` mixes those that can be its parts."""

from __future__ import annotations

from typing import Any

from .boxes import Boxes
from .curves import Curves
from .lines import Lines
from .spheres import Spheres
from .triangles import Triangles

#: Each kind by its name. A new kind is a class in a file of its own, and a row here.
KINDS: dict[str, type[Any]] = {kind.__name__: kind for kind in (Lines, Spheres, Curves, Triangles, Boxes)}
