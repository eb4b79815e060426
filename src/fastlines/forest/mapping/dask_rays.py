"""Rays in arrays of Dask, whose hits are arrays of Dask, too: each block of rays is answered when it is computed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...errors import InputError
from ...query.at import At, has_exit
from ...query.ray_arguments import RayArguments
from ...support.optional import optional
from .dask_hits import OPTIONAL, DaskAllHits, DaskFirstHits, record_of, records
from .forest_address import ForestAddress
from .task import Fault, Task, do, installed_version

if TYPE_CHECKING:
    from ..forest import Forest

#: What rays may have one value each of.
SCALARS = ("radius", "spread", "t_min", "t_max")


def is_dask(array: object) -> bool:
    """Return whether something is an array of Dask, without importing Dask."""
    return type(array).__module__.startswith("dask.array.")


def has_dask_rays(given: RayArguments) -> bool:
    """Return whether any of the rays is in arrays of Dask."""
    return any(is_dask(getattr(given, name)) for name in ("origins", "directions", *SCALARS))


@dataclass(frozen=True, eq=False)
class BlockWork:
    """A query of a block of rays; see `Work`."""

    forest: ForestAddress
    kernel: str
    given: RayArguments
    #: The name of a method of `Query`, and its arguments.
    query: str
    how: tuple[Any, ...]
    #: The type of a row of hits; None for a query that returns an array.
    record: np.dtype[Any] | None
    version: str

    def done(self) -> Any:
        """Check the rays, and answer them with the tiles that this process sees."""
        found = getattr(self.forest.opened()._query(self.kernel, self.given), self.query)(*self.how)
        if self.record is None:
            return found
        rows = records(found, self.record)
        return (found.counts, rows) if hasattr(found, "offsets") else rows

    def answer(self, *arrays: npt.NDArray[Any], names: tuple[str, ...]) -> Any:
        """Answer a block of rays."""
        given: dict[str, Any] = dict(zip(("origins", "directions", *names), arrays, strict=True))
        given |= {name: given[name][..., 0] for name in names}
        work = replace(self, given=replace(self.given, **given))
        result = do(Task(0, work, version=self.version))
        if isinstance(result, Fault):
            raise result.error()
        return result.value


@dataclass(frozen=True, eq=False)
class DaskRays:
    """Rays in arrays of Dask, which find their own answers; see `DeviceRays`."""

    forest: Forest
    kernel: str
    given: RayArguments
    #: Origins and directions, (…, 3), and what has a value for each ray, (…, 1), in the same blocks.
    arrays: tuple[Any, ...]
    #: The names of the latter.
    names: tuple[str, ...]

    @classmethod
    def of(cls, forest: Forest, kernel: str, given: RayArguments) -> DaskRays:
        """Check shapes, and give all arrays the same blocks.

        Raises
        ------
        InputError
            If shapes do not match, sizes of blocks are not known, or an option is for each ray.
        """
        array = _dask("dask.array")
        for name in ("ignore", "ignore_strands"):
            if np.ndim(getattr(given, name)) > 1 or hasattr(getattr(given, name), "prim"):
                raise InputError(f"{name} is for each ray; with rays in arrays of Dask give numbers for all rays, (k,)")
        if given.progress:
            raise InputError(
                "rays in arrays of Dask are answered when these are computed, so there is no progress now; leave "
                "progress= out, and use dask.diagnostics or the dashboard"
            )
        names = tuple(name for name in SCALARS if np.ndim(getattr(given, name)) > 0)
        vectors = [array.asarray(getattr(given, name)) for name in ("origins", "directions")]
        if any(vector.ndim == 0 or vector.shape[-1] != 3 for vector in vectors):
            shapes = " and directions ".join(str(vector.shape) for vector in vectors)
            raise InputError(f"origins have shape {shapes}; expected (…, 3) of both")
        each = [array.asarray(getattr(given, name))[..., None] for name in names]
        if any(np.isnan(values.shape).any() for values in (*vectors, *each)):
            raise InputError("rays have blocks of unknown sizes; call compute_chunk_sizes() of their arrays first")
        try:
            shape = np.broadcast_shapes(*(vector.shape[:-1] for vector in vectors))
            each = [array.broadcast_to(values, (*shape, 1)) for values in each]
        except ValueError as error:
            raise InputError(f"shapes of rays do not match: {error}") from None
        vectors = [array.broadcast_to(vector, (*shape, 3)) for vector in vectors]
        # Cut all of them as the one with the most blocks.
        blocks = max((values.chunks[:-1] for values in (*vectors, *each)), key=lambda chunks: [*map(len, chunks)])
        arrays = [values.rechunk((*blocks, values.shape[-1])) for values in (*vectors, *each)]
        taken: dict[str, Any] = dict.fromkeys(("origins", "directions", *names), 0.0)
        plain = replace(given, **taken)
        return cls(forest, kernel, plain, tuple(arrays), names)

    @property
    def has_spread(self) -> bool:
        """Whether the reach of any ray grows along it."""
        return "spread" in self.names or self.given.has_spread

    def first_hit(self, at: At) -> DaskFirstHits:
        """See `DeviceRays`."""
        record = record_of(self.forest.geometry, has_exit(at))
        rows = self._mapped(self._work("first_hit", (at,), record), record)
        return DaskFirstHits(**self._columns(rows), geometry=self.forest.geometry)

    def any_hit(self, at: At) -> Any:
        """See `DeviceRays`."""
        return self._mapped(self._work("any_hit", (at,)), np.dtype(np.bool_))

    def count_hits(self, at: At) -> Any:
        """See `DeviceRays`."""
        return self._mapped(self._work("count_hits", (at,)), np.dtype(np.int64))

    def list_hits(self, at: At, k: int | None, by_distance: bool) -> DaskAllHits:
        """See `DeviceRays`."""
        record = record_of(self.forest.geometry, has_exit(at))
        if k is not None:
            return self._listed(self._work("next_hits", (k, at, "distance" if by_distance else "t"), record))
        return self._listed(self._work("all_hits", (at, None), record))

    def _work(self, query: str, how: tuple[Any, ...], record: np.dtype[Any] | None = None) -> BlockWork:
        address = ForestAddress.of(self.forest)
        return BlockWork(address, self.kernel, self.given, query, how, record, installed_version())

    def _mapped(self, work: BlockWork, kind: np.dtype[Any]) -> Any:
        """Return an array with a value for each ray."""
        array, dask = _dask("dask.array"), _dask("dask.base")
        ndim = self.arrays[0].ndim - 1
        return array.map_blocks(
            work.answer, *self.arrays, names=self.names, drop_axis=ndim, meta=np.empty((0,) * ndim, kind), dtype=kind,
            name=f"{work.query}-{dask.tokenize(work.forest, work.how, work.record, *self.arrays)}"
        )  # fmt: skip

    def _listed(self, work: BlockWork) -> DaskAllHits:
        """Return lists, from the blocks of the rays in a row."""
        array, dask = _dask("dask.array"), _dask("dask")
        flat = [values.reshape(-1, values.shape[-1]) for values in self.arrays]
        sizes = flat[0].chunks[0]
        flat = [values.rechunk((sizes, values.shape[-1])) for values in flat]
        answer = dask.delayed(work.answer, pure=False, nout=2)
        blocks = zip(*(values.to_delayed().ravel() for values in flat), strict=True)
        found = [answer(*block, names=self.names) for block in blocks]
        assert work.record is not None
        counts = [array.from_delayed(block[0], (size,), np.int64) for block, size in zip(found, sizes, strict=True)]
        rows = array.concatenate([array.from_delayed(block[1], (np.nan,), work.record) for block in found])
        counts = array.concatenate(counts)
        offsets = array.concatenate([np.zeros(1, np.int64), array.cumsum(counts)])
        query, how = work.query, work.how

        def merge() -> DaskAllHits:
            return self._listed(replace(work, query=query, how=(how[0], "strand")))

        return DaskAllHits(
            **self._columns(rows), geometry=self.forest.geometry, counts=counts, offsets=offsets, merge=merge
        )

    @staticmethod
    def _columns(rows: Any) -> dict[str, Any]:
        return {**dict.fromkeys(OPTIONAL), **{name: rows[name] for name in rows.dtype.names}}


def _dask(module: str) -> Any:
    return optional(module, "a query with arrays of Dask", "cluster")
