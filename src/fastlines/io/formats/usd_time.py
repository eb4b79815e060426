"""USD at a time, or at the earliest one, where each value is that of its first sample or knot.

USD calls the earliest time by a number, -1.8e308. Values that are sampled are right there. What is extrapolated is not:
PointInstancers by their velocities, and splines before their first knot.
"""

from __future__ import annotations

from typing import Any

#: What places the instances of a PointInstancer, without their motion.
_PLACES = ("protoIndices", "positions", "orientations", "orientationsf", "scales")


def time_of(attribute: Any, time: Any) -> Any:
    """Return the time at which an attribute is read: at the earliest one, splines are read at their first knot."""
    # Versions of the library before 24.11 have no splines.
    if time.IsEarliestTime() and getattr(attribute, "HasSpline", bool)():
        knots = attribute.GetSpline().GetKnots()
        if len(knots):
            return type(time)(min(knots.keys()))
    return time


class Transforms:
    """The transforms of prims at a time, each made once.

    Parameters
    ----------
    time : Usd.TimeCode
    """

    def __init__(self, time: Any) -> None:
        self.time = time
        self._local: dict[Any, tuple[Any, bool]] = {}

    def local(self, prim: Any) -> tuple[Any, bool]:
        """Return the transform of a prim to the one above it, and whether it is to the world instead."""
        from pxr import Gf, UsdGeom

        path = prim.GetPath()
        if path not in self._local:
            matrix, xformable = Gf.Matrix4d(1), UsdGeom.Xformable(prim)
            ops = xformable.GetOrderedXformOps() if xformable else []
            times = [time_of(op.GetAttr(), self.time) for op in ops]
            if any(time != self.time for time in times):
                for op, time in zip(reversed(ops), reversed(times), strict=True):
                    matrix *= op.GetOpTransform(time)
            elif xformable:
                matrix = xformable.GetLocalTransformation(self.time)
            self._local[path] = matrix, bool(xformable) and xformable.GetResetXformStack()
        return self._local[path]

    def relative(self, prim: Any, origin: Any) -> Any:
        """Return the transform of a prim to one above it, or to the world if one in between says so."""
        from pxr import Gf

        matrix, resets = Gf.Matrix4d(1), False
        while prim and prim != origin and not resets:
            local, resets = self.local(prim)
            matrix *= local
            prim = prim.GetParent()
        return matrix

    def instances(self, instancer: Any) -> Any:
        """Return the transform of each instance of a PointInstancer, without that of its prototype."""
        from pxr import Usd, UsdGeom

        at = self.time
        if at.IsEarliestTime():
            # Copy what has no motion, for USD would move the instances back to the number that stands for the time.
            stage = Usd.Stage.CreateInMemory()
            copy = UsdGeom.PointInstancer.Define(stage, instancer.GetPath())
            for name in _PLACES:
                given = instancer.GetPrim().GetAttribute(name)
                if given and (value := given.Get(at)) is not None:
                    copy.GetPrim().CreateAttribute(name, given.GetTypeName()).Set(value)
            instancer, at = copy, Usd.TimeCode.Default()
        return instancer.ComputeInstanceTransformsAtTime(at, at, instancer.ExcludeProtoXform, instancer.IgnoreMask)
