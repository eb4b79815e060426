"""Points and options of a query, as they are given; see `ray_arguments`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

from ...progress import ProgressOption
from ..options import shows_options


class PointOptions(TypedDict, total=False):
    """The keywords that all queries about points take; `Tree.nearest` explains them."""

    to: str | None
    ignore: Any
    ignore_strands: Any
    parts: npt.ArrayLike | None
    invalid: str
    progress: ProgressOption


@dataclass(frozen=True, eq=False)
class PointArguments:
    """Points and options before they are checked; `Tree.nearest` explains them."""

    points: npt.ArrayLike
    radius: npt.ArrayLike = np.inf
    #: What errors call the radius.
    radius_name: str = "radius"
    to: str | None = None
    ignore: Any = None
    ignore_strands: Any = None
    parts: npt.ArrayLike | None = None
    invalid: str = "error"
    progress: ProgressOption = False


#: Shows the keywords of `PointOptions` in the signature of a query that takes them as ``**options``.
shows_point_options = shows_options(PointOptions, PointArguments)
