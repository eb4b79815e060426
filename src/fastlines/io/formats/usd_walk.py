"""The prims of a USD stage that are curves, with the place of each copy: transforms, instances and PointInstancers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..source import Source
from .usd_time import Transforms
from .usd_values import Float64Array, Remarks, numbers

#: How many bytes a visit counts as, against the limit of what a file may unpack to: of any prim, of one with curves,
#: and of a copy that a PointInstancer makes. Visits take tenths of a millisecond, a millisecond and a microsecond.
_BYTES_PER_PRIM, _BYTES_PER_CURVES, _BYTES_PER_COPY = 256, 2048, 64


class Walk:
    """A walk over the prims of a stage, in their order; instances are visited as if they were copies.

    Parameters
    ----------
    source : Source
        The file, for errors.
    time : Usd.TimeCode
    remarks : Remarks
    limit : int
        To how many bytes curves may grow. A small file can ask for copies of copies without end.
    """

    def __init__(self, source: Source, time: Any, remarks: Remarks, limit: int) -> None:
        self.source, self.time, self.remarks, self.left, self.limit = source, time, remarks, limit, limit
        self.transforms = Transforms(time)
        self.other: dict[str, int] = {}
        self._shown: dict[Any, bool] = {}

    def spend(self, n_bytes: int) -> None:
        """Count what is visited or copied; refuse a stage that grows beyond the limit."""
        self.left -= n_bytes
        if self.left < 0:
            raise self.source.error(
                f"its instances make more than {self.limit} bytes of curves, far more than such a file would; "
                "if it is valid, read parts of it with prim="
            )

    def curves(self, root: Any) -> Iterator[tuple[Any, Float64Array]]:
        """Yield each prim of curves below a root, and a matrix (k, 4, 4) to the world for each of its k copies."""
        from pxr import Usd

        stage = root.GetStage()
        yield from self._below(root, np.eye(4)[None], stage.GetPseudoRoot(), (), Usd)

    def _below(
        self, root: Any, frames: Float64Array, origin: Any, within: tuple[Any, ...], usd: Any
    ) -> Iterator[tuple[Any, Float64Array]]:
        """Yield the prims below a root, whose frames are those of the origin, a prim above or the root itself."""
        from pxr import UsdGeom

        prims = iter(usd.PrimRange(root, usd.TraverseInstanceProxies(usd.PrimDefaultPredicate)))
        for prim in prims:
            self.spend(_BYTES_PER_PRIM)
            is_curve = prim.IsA(UsdGeom.BasisCurves) or prim.IsA(UsdGeom.HermiteCurves)
            is_instancer = prim.IsA(UsdGeom.PointInstancer)
            if not is_curve and not is_instancer:
                if prim.IsA(UsdGeom.Gprim):
                    self.other[str(prim.GetTypeName())] = self.other.get(str(prim.GetTypeName()), 0) + 1
                continue
            if is_instancer:
                prims.PruneChildren()  # its prototypes are not where they stand
            if not self._is_shown(prim, origin):
                self.remarks.add("left out, as it is invisible", prim.GetPath())
                continue
            places = np.asarray(self.transforms.relative(prim, origin), np.float64) @ frames
            if is_curve:
                if (purpose := str(UsdGeom.Imageable(prim).ComputePurpose())) in ("guide", "proxy"):
                    self.remarks.add(f"is read, though its purpose is {purpose!r}; prim= reads a part", prim.GetPath())
                self.spend(_BYTES_PER_CURVES + _BYTES_PER_COPY * len(places))
                yield prim, places
            elif prim.GetPath() in within:
                self.remarks.add("left out, as it is among its own prototypes", prim.GetPath())
            else:
                yield from self._instances(prim, places, (*within, prim.GetPath()), usd)

    def _instances(
        self, prim: Any, places: Float64Array, within: tuple[Any, ...], usd: Any
    ) -> Iterator[tuple[Any, Float64Array]]:
        """Yield the prims of each prototype of a PointInstancer, once for all of its instances."""
        from pxr import UsdGeom

        instancer = UsdGeom.PointInstancer(prim)
        indices = numbers(instancer.GetProtoIndicesAttr().Get(self.time))
        prototypes = instancer.GetPrototypesRel().GetForwardedTargets()
        made = self.transforms.instances(instancer)
        if indices is None or indices.ndim != 1 or len(made) != len(indices):
            self.remarks.add("left out: it does not have one position for each instance", prim.GetPath())
            return
        transforms = np.asarray(made, np.float64).reshape(-1, 4, 4)
        mask = np.asarray(instancer.ComputeMaskAtTime(self.time), np.bool_)
        shown = mask if len(mask) == len(indices) else np.ones(len(indices), np.bool_)
        if not shown.all():
            self.remarks.add("some instances are left out, as they are inactive or invisible", prim.GetPath())
        if (wrong := (indices < 0) | (indices >= len(prototypes))).any():
            self.remarks.add("some instances are left out, as they have no prototype", prim.GetPath())
            shown &= ~wrong
        for i, target in enumerate(prototypes):
            root = prim.GetStage().GetPrimAtPath(target)
            chosen = transforms[shown & (indices == i)]
            if not len(chosen):
                continue
            if not root:
                self.remarks.add(f"some instances are left out, as there is no prototype {target}", prim.GetPath())
                continue
            self.spend(_BYTES_PER_COPY * len(chosen) * len(places))
            local, _ = self.transforms.local(root)
            frames = np.asarray(local, np.float64) @ chosen[None] @ places[:, None]
            yield from self._below(root, frames.reshape(-1, 4, 4), root, within, usd)

    def _is_shown(self, prim: Any, origin: Any) -> bool:
        """Return whether neither a prim nor one above it, up to the origin, is invisible."""
        from pxr import UsdGeom

        key = (prim.GetPath(), origin.GetPath())
        if key not in self._shown:
            imageable = UsdGeom.Imageable(prim)
            hides = bool(imageable) and imageable.GetVisibilityAttr().Get(self.time) == UsdGeom.Tokens.invisible
            above = prim.GetParent()
            is_last = prim == origin or not above or above.IsPseudoRoot()
            self._shown[key] = not hides and (is_last or self._is_shown(above, origin))
        return self._shown[key]
