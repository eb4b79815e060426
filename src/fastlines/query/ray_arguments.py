"""Rays and options of a query, as they are given: the arguments of all queries, listed once.

Queries take `RayOptions` as ``**options``, which type checkers and editors read. `shows_ray_options` writes the same
keywords, with their defaults, into the signature that `help` and the documentation show.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypedDict, TypeVar

import numpy as np
import numpy.typing as npt

from ..progress import ProgressOption
from .options import shows_options

Function = TypeVar("Function", bound=Callable[..., Any])


class RayOptions(TypedDict, total=False):
    """The keywords that all queries take; `Tree.first_hit` explains them, and `RayArguments` has their defaults."""

    spread: npt.ArrayLike
    ignore: Any
    ignore_strands: Any
    parts: npt.ArrayLike | None
    t_min: npt.ArrayLike
    t_max: npt.ArrayLike
    invalid: str
    progress: ProgressOption


@dataclass(frozen=True, eq=False)
class RayArguments:
    """Rays and options before they are checked; `Tree.first_hit` explains them."""

    origins: npt.ArrayLike
    directions: npt.ArrayLike
    radius: npt.ArrayLike | None = None
    spread: npt.ArrayLike = 0.0
    ignore: Any = None
    ignore_strands: Any = None
    parts: npt.ArrayLike | None = None
    t_min: npt.ArrayLike = 0.0
    t_max: npt.ArrayLike = np.inf
    invalid: str = "error"
    progress: ProgressOption = False

    @property
    def has_spread(self) -> bool:
        """Whether a spread is given: a number other than 0, or an array, which may be in the memory of a GPU."""
        return not (isinstance(self.spread, int | float) and self.spread == 0)


def shows_ray_options(query: Function) -> Function:
    """Show the keywords of `RayOptions` in the signature of a query that takes them as ``**options``.

    Examples
    --------
    >>> import inspect
    >>> @shows_ray_options
    ... def nearest(origins, *, k=1, **options):
    ...     return RayArguments(origins, (0, 0, 1), **options)
    >>> list(inspect.signature(nearest).parameters)[:3], inspect.signature(nearest).parameters["t_max"].default
    (['origins', 'spread', 'ignore'], inf)
    """
    return shows_options(RayOptions, RayArguments)(query)
