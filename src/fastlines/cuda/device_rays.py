"""Rays in the memory of a GPU, as arrays of torch, CuPy or JAX by DLPack, and their answers there: no copies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray, is_on_device
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.offsets import NO_OFFSET
from ..query.at import At
from ..query.ray_arguments import RayArguments
from ..query.rays import limits_of, require_radius, scene_bounds, warn_of_radius
from .backend import CudaBackend, RaysOnDevice
from .columns import DeviceColumns
from .device import ViewedArray
from .records import limits_record


@dataclass(frozen=True, eq=False)
class DeviceHits:
    """Hits in the memory of a GPU; each field has ``__dlpack__``, as ``torch.from_dlpack`` takes it.

    Attributes
    ----------
    t, prim, u, distance, t_out
        As in `FirstHits`; of lists, one entry a hit.
    offsets
        Of lists, as in `AllHits`, (n_rays + 1,) int64; None for first hits.
    """

    t: Any
    prim: Any
    u: Any
    distance: Any
    t_out: Any
    offsets: Any = None

    def merged_by_strand(self) -> DeviceHits:
        """Refuse to merge hits."""
        raise InputError("hits in the memory of a GPU are not merged; leave out merge=, or pass rays as NumPy arrays")


@dataclass(frozen=True)
class DeviceRayBatch:
    """Checked rays in the memory of a GPU; `shape` is the shape of the answer."""

    backend: CudaBackend
    rays: RaysOnDevice
    shape: tuple[int, ...]
    has_spread: bool

    def first_hit(self, at: At) -> DeviceHits:
        """Find the nearest hit of each ray."""
        return self._exported(self.backend.find_first(self.rays, at), self.shape)

    def any_hit(self, at: At) -> Any:
        """Find out for each ray whether it hits anything."""
        return self._export(self.backend.find_any(self.rays, at), self.shape, np.bool_)

    def count_hits(self, at: At) -> Any:
        """Count the primitives that each ray hits."""
        return self._export(self.backend.count(self.rays, at), self.shape, np.int64)

    def list_hits(self, at: At, k: int | None, by_distance: bool) -> DeviceHits:
        """List all hits of each ray, or the k best."""
        lists = self.backend.list(self.rays, at, k, by_distance)
        offsets = self._export(lists.offsets, (self.rays.n + 1,), np.int64)
        return self._exported(lists.columns, (lists.columns.n,), offsets)

    def _exported(self, columns: DeviceColumns, shape: tuple[int, ...], offsets: Any = None) -> DeviceHits:
        t, u, distance, t_out = (
            None if column is None else self._export(column, shape, np.float32)
            for column in (columns.t, columns.u, columns.distance, columns.t_out)
        )
        return DeviceHits(t, self._export(columns.prim, shape, np.int64), u, distance, t_out, offsets)

    def _export(self, memory: Any, shape: tuple[int, ...], dtype: Any) -> Any:
        return self.backend.scene.device.export(memory, shape, dtype)


def check_device_query(
    backend: CudaBackend, geometry: AnyGeometry, box: FloatArray, given: RayArguments
) -> DeviceRayBatch:
    """Check rays of which at least origins are in the memory of the GPU, for geometry in this box; see `check_query`.

    With a spread, the backend must be that of a scene for such rays.

    Raises
    ------
    InputError
        If an array has another type or shape than it should, or a ray is not valid.
    """
    refused = {
        "invalid": given.invalid != "error",
        "ignore": given.ignore is not None,
        "ignore_strands": given.ignore_strands is not None,
        "parts": given.parts is not None,
    }
    for name, is_given in refused.items():
        if is_given:
            raise InputError(f"rays in the memory of a GPU take no {name}=; leave it out, or pass NumPy arrays")
    if geometry.offset != NO_OFFSET:
        raise InputError(
            f"the lines have an offset, {geometry.offset}, which is subtracted from origins in float64, and rays in "
            "the memory of a GPU are float32; pass rays as NumPy arrays, or query tree.without_offset() with rays less "
            "the offset"
        )
    if not given.has_spread:
        require_radius(geometry, given.radius)
    bounds = scene_bounds(geometry, box)
    device = backend.scene.device
    points = _viewed(backend, given.origins, "origins", None)
    if points.shape[-1:] != (3,):
        raise InputError(f"origins have shape {points.shape}; expected (…, 3): x y z of each ray")
    shape = points.shape[:-1]
    n = math.prod(shape)
    arrays = [points, _viewed(backend, given.directions, "directions", points.shape, (3,))]
    radius = 0.0 if given.radius is None else given.radius
    if not is_on_device(radius):
        warn_of_radius(geometry, radius)
    scalars = {"radius": radius, "t_min": given.t_min, "t_max": given.t_max, "spread": given.spread}
    for name, values in scalars.items():
        arrays.append(_viewed(backend, values, name, shape, ()))
    steps = [3, 0 if arrays[1].shape == (3,) else 3, *(0 if array.shape == () else 1 for array in arrays[2:])]
    rays = backend.rays_on_device([array.pointer for array in arrays], n, steps, arrays)
    limits, found = device.upload(limits_record(*limits_of(bounds))), device.upload(np.zeros(1, np.uint32))
    if n:
        backend.scene.kernels.launch("check_rays", n, limits.pointer, rays.record.pointer, found.pointer)
    n_invalid = int(device.download(found, np.uint32, 1)[0])
    if n_invalid:
        raise InputError(
            f"{n_invalid} of {n} rays are not valid: they hold NaN or Inf, have a direction of length zero, a radius "
            "or spread that is too large, or bounds that are not in order; pass them as NumPy arrays to learn which "
            "and why"
        )
    return DeviceRayBatch(backend, rays, shape, given.has_spread)


def _viewed(backend: CudaBackend, values: Any, name: str, *shapes: tuple[int, ...] | None) -> ViewedArray:
    """View an array of the device without a copy, or upload numbers; check type and shape, where one is given."""
    device = backend.scene.device
    if is_on_device(values):
        array = device.view(values)
    else:
        numbers = np.asarray(values, np.float32)
        memory = device.upload(numbers)
        array = ViewedArray(memory.pointer, numbers.shape, numbers.dtype, True, memory)
    if array.dtype != np.float32 or not array.contiguous:
        raise InputError(
            f"{name} are {array.dtype}{'' if array.contiguous else ', and not contiguous'}; expected contiguous float32"
            " in the memory of the GPU, so that nothing is copied"
        )
    if None not in shapes and array.shape not in shapes:
        raise InputError(f"{name} have shape {array.shape}; expected {' or '.join(map(str, shapes))}")
    return array
