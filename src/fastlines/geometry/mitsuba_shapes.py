"""Lines and curves from shapes and scenes of Mitsuba 3, which are recognised by their attributes.

| object                                  | recognised by                               |
|-----------------------------------------|---------------------------------------------|
| a shape                                 | ``shape_type``, ``class_name``, ``traverse`` |
| a scene, which has several              | ``shapes``, ``sensors``, ``traverse``       |

The parameters of *linearcurve* and *bsplinecurve* are ``control_points``, x, y, z and the radius of each point, in the
world, and ``segment_indices``, the first point of each segment. Where no segment joins two points, a curve ends.
"""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np

from ..arrays import AnyArray, IntArray, kind_of
from ..errors import FileWarning, InputError
from ..support.texts import kinds_text
from ..support.warn_caller import warn_caller
from .curves import Curves
from .lines import Lines
from .making import Making, has
from .to_array import to_array

#: The attribute with the position of a shape in its scene.
SHAPE = "shape"
#: The classes of shapes, and how many points a segment of each has.
_LINEAR, _SPLINE = "LinearCurve", "BSplineCurve"
_N_POINTS = {_LINEAR: 2, _SPLINE: 4}


def of_mitsuba(obj: Any, how: Making) -> Lines | None:
    """Return the lines of a shape *linearcurve*, or of all of a scene; None if the object is none."""
    if (found := _Shapes.of(obj, _LINEAR)) is None:
        return None
    if found.others and not found.is_scene:
        (kind,) = found.others
        instead = "fl.curves(shape) makes curves of it" if kind == _SPLINE else "expected a linearcurve or a scene"
        raise InputError(f"lines are a shape {kind} of Mitsuba; {instead}")
    if found.others:
        instead = "; fl.curves(scene) takes the BSplineCurve" if _SPLINE in found.others else ""
        how.warn(f"shapes of the scene other than {_LINEAR} are not read: {kinds_text(found.others)}{instead}")
    points, counts = found.points()
    made = Lines.from_points(points[:, :3], counts, radius=points[:, 3], **how.options)
    return replace(made, attributes=found.attributes(made.strands))


def curves(obj: Any, *, tolerance: float | None = None, offset: Any = None, invalid: str = "error") -> Curves:
    r"""Make curves of a shape *bsplinecurve* of Mitsuba 3, or of all such shapes of a scene.

    Parameters
    ----------
    obj : mitsuba.Shape or mitsuba.Scene
        Of a scene, the attribute ``shape`` is the position in ``scene.shapes()``.
    tolerance, offset, invalid
        As of `Curves.from_strands`.

    Returns
    -------
    Curves
        A strand for each spline, with its radii.

    Raises
    ------
    InputError
        If the object is something else. `lines` takes *linearcurve*, and all other objects.

    Warns
    -----
    FileWarning
        Of other shapes in a scene.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import mitsuba as mi, fastlines as fl
    >>> mi.set_variant("scalar_rgb")
    >>> path = pathlib.Path(tempfile.mkdtemp(), "hair.txt")
    >>> size = path.write_text("\n".join(["0 0 0 .1", "1 0 0 .1", "2 1 0 .1", "3 1 0 .1"]))
    >>> fl.curves(mi.load_dict({"type": "bsplinecurve", "filename": str(path)}))
    <Curves: 1 curve, 1 strand, radius>
    """
    found = _Shapes.of(obj, _SPLINE)
    if found is None or (found.others and not found.is_scene):
        kind = kind_of(obj) if found is None else f"a shape {next(iter(found.others))} of Mitsuba"
        raise InputError(f"curves are {kind}; expected a bsplinecurve of Mitsuba or a scene: fl.lines takes others")
    if found.others:
        warn_caller(f"shapes of the scene other than {_SPLINE} are not read: {kinds_text(found.others)}", FileWarning)
    points, counts = found.points()
    made = Curves.from_strands(
        points[:, :3], counts, basis="bspline", radius=points[:, 3], tolerance=tolerance, offset=offset, invalid=invalid
    )
    return replace(made, attributes=found.attributes(made.strands))


class _Shapes:
    """The shapes of one class, with their positions in a scene, and how many there are of other classes."""

    def __init__(self, shapes: list[Any], kind: str, is_scene: bool) -> None:
        names = [shape.class_name() for shape in shapes]
        self.kind, self.is_scene = kind, is_scene
        self.numbers = [i for i, name in enumerate(names) if name == kind]
        self.others = {name: names.count(name) for name in names if name != kind}
        self._parts = [_points_and_counts(shapes[i], _N_POINTS[kind]) for i in self.numbers]

    @classmethod
    def of(cls, obj: Any, kind: str) -> _Shapes | None:
        """Return the shapes of an object of Mitsuba; None if it is none."""
        if has(obj, "shape_type", "class_name", "traverse"):
            return cls([obj], kind, False)
        if has(obj, "shapes", "sensors", "traverse"):
            return cls(list(obj.shapes()), kind, True)
        return None

    def points(self) -> tuple[AnyArray, IntArray]:
        """Return the points with their radii, (m, 4), and how many of them each curve has."""
        points = [np.empty((0, 4), np.float32), *(points for points, _ in self._parts)]
        return np.concatenate(points), np.concatenate([np.empty(0, np.int64), *(counts for _, counts in self._parts)])

    def attributes(self, strands: IntArray) -> dict[str, AnyArray]:
        """Return the number of the shape of each strand's rows, if the shapes are those of a scene."""
        n_curves = [len(counts) for _, counts in self._parts]
        return {SHAPE: np.repeat(np.array(self.numbers, np.int64), n_curves)[strands]} if self.is_scene else {}


def _points_and_counts(shape: Any, n_points: int) -> tuple[AnyArray, IntArray]:
    """Return the points of a shape with their radii, and how many of them each curve has."""
    parameters = import_module("mitsuba").traverse(shape)  # which made the shape
    points = np.asarray(to_array(parameters["control_points"]), np.float32).reshape(-1, 4)
    first = np.asarray(to_array(parameters["segment_indices"])).astype(np.int64).reshape(-1)
    begins = np.ones(len(points), np.bool_)
    for i in range(1, n_points):
        begins[first + i] = False
    return points, np.diff(np.append(np.flatnonzero(begins), len(points)))
