"""Hits as arrays of Dask: what they are is known, and they are found when they are computed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ...geometry.any_geometry import AnyGeometry
from ...query.hits import AllHits, FirstHits
from ...support.optional import optional

#: The columns of hits that not all of them have.
OPTIONAL = ("t_out", "part", "strand")


def record_of(geometry: AnyGeometry, with_t_out: bool) -> np.dtype[Any]:
    """Return the type of a hit as a block returns it."""
    columns = [("t", np.float32), ("prim", np.int64), ("u", np.float32), ("distance", np.float32)]
    columns += [("t_out", np.float32)] * with_t_out + [("part", np.int64)] * geometry.has_parts
    return np.dtype(columns + [("strand", np.int64)] * (geometry.n_strands > 0))


def records(hits: FirstHits | AllHits, record: np.dtype[Any]) -> np.ndarray[Any, Any]:
    """Return hits as rows of one array."""
    found = np.empty(hits.prim.shape, record)
    for name in record.names or ():
        found[name] = getattr(hits, name)
    return found


@dataclass(frozen=True, eq=False, repr=False)
class DaskHits:
    """What both kinds of hits have."""

    t: Any
    prim: Any
    u: Any
    distance: Any
    t_out: Any
    part: Any
    strand: Any
    geometry: AnyGeometry

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.prim!r}>"

    def _computed(self, **options: Any) -> dict[str, Any]:
        """Compute all columns in one go."""
        dask = optional("dask", "a query with arrays of Dask", "cluster")
        known = {of.name: getattr(self, of.name) for of in fields(self)}
        lazy = {name: values for name, values in known.items() if hasattr(values, "dask") and name != "strand"}
        return dict(zip(lazy, dask.compute(*lazy.values(), **options), strict=True))


@dataclass(frozen=True, eq=False, repr=False)
class DaskFirstHits(DaskHits):
    """The nearest hit of each ray: arrays of Dask, in the blocks of the rays.

    Attributes
    ----------
    t, prim, u, distance, t_out, part
        As in `FirstHits`.
    strand : int64 or None
        The strand of each primitive, -1 for a miss; None if there are no strands.
    """

    @property
    def hit(self) -> Any:
        """Whether each ray hits anything."""
        return self.prim >= 0

    def compute(self, **options: Any) -> FirstHits:
        """Find the hits, and return them as arrays of NumPy, without their rays; options are those of `dask.compute`.

        Invalid rays that were skipped count as misses, and are not listed.
        """
        found = {"t_out": None, "part": None, **self._computed(**options)}
        return FirstHits(**found, skipped=np.zeros(0, np.int64), geometry=self.geometry)


@dataclass(frozen=True, eq=False, repr=False)
class DaskAllHits(DaskHits):
    """Lists of hits: arrays of Dask, whose blocks have unknown sizes until they are computed.

    Attributes
    ----------
    counts : (n_rays,) int64
        How many hits each ray has, in the order of the flattened rays.
    offsets : (n_rays + 1,) int64
    t, prim, u, distance, t_out, part
        As in `AllHits`.
    strand : int64 or None
        The strand of each hit; None if there are no strands.
    """

    counts: Any
    offsets: Any
    merge: Callable[[], DaskAllHits]

    def merged_by_strand(self) -> DaskAllHits:
        """See `AllHits`."""
        return self.merge()

    def compute(self, **options: Any) -> AllHits:
        """Find the hits, and return them as arrays of NumPy, without their rays; options are as in `dask.compute`."""
        found = {"t_out": None, "part": None, **self._computed(**options)}
        del found["counts"]
        return AllHits(**found, skipped=np.zeros(0, np.int64), geometry=self.geometry)
