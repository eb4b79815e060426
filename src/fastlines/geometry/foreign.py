"""Lines from objects of other libraries, which are recognised by their attributes: none of them is imported here.

| object                                                 | recognised in, or by                          |
|--------------------------------------------------------|-----------------------------------------------|
| tractograms and streamlines of nibabel, DIPY and trx   | `tractograms`                                 |
| neurons of navis                                       | `neurons`                                     |
| curves and scenes of Mitsuba                           | `mitsuba_shapes`                              |
| meshes of PyVista and VTK, and several of them         | `vtk_objects`                                 |
| geometries of shapely, tables of geopandas             | `map_features`                                |
| paths of trimesh                                       | `trimesh_paths`                               |
| points and offsets                                     | a tuple of (m, 3) and (k + 1,) arrays         |
| polylines                                              | a list, a tuple or an iterator of (m, 3) arrays |
| segments                                               | an array; ``__dlpack__`` or ``__array__``     |
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arrays import INVALID, LEAST, AnyArray, choice, kind_of, number, to_integers
from ..errors import FileWarning, InputError
from ..support.warn_caller import warn_caller
from .lines import Lines, as_lines
from .making import FLAT, Making, has, in_space, with_z
from .map_features import of_features
from .mitsuba_shapes import of_mitsuba
from .neurons import of_neurons
from .offsets import check_offset, with_offset
from .to_array import to_array
from .tractograms import of_tractogram
from .trimesh_paths import of_path
from .vtk_objects import of_vtk


def lines(obj: Any, *, offset: Any = None, invalid: str = "error", tolerance: float | None = None) -> Lines:
    """Make lines of an object of another library, of polylines, or of an array of segments.

    Parameters
    ----------
    obj : object
        One of these; no library has to be installed but that of the object.

        - `Lines`, which are returned as they are.
        - A tractogram of nibabel, a ``StatefulTractogram`` of DIPY, or a ``TrxFile`` of trx. Values per point become
          ``end_attributes``, those per streamline ``attributes``. Points become millimetres of the world ("RASMM"), by
          ``affine_to_rasmm`` or by the space and the origin of a ``StatefulTractogram``, which does not change. The
          voxel grid of a ``StatefulTractogram``, or of the header of a file, is kept in ``metadata["grid"]``.
        - An ``ArraySequence`` or ``Streamlines``.
        - A ``TreeNeuron`` of navis, or a ``NeuronList`` or list of them: a strand for each unbranched section, with the
          radius, as from a ``.swc`` file. Both ends have the attributes ``id`` and ``type``, which navis calls
          ``node_id`` and ``label``. The attribute ``neuron`` is the position in a list.
        - A shape *linearcurve* of Mitsuba, or a scene: all such shapes in it; the attribute ``shape`` is the position
          in ``scene.shapes()``. `curves` takes the shape *bsplinecurve*.
        - A ``PolyData`` or an ``UnstructuredGrid`` of PyVista or VTK: its lines, with the arrays of their points and of
          their cells; the array ``radius``, in either case, and the texts ``unit`` and ``up`` of its field data mean
          the same as in a file. Of a ``MultiBlock``, the lines of all blocks; the attribute ``block`` counts these.
        - A geometry of shapely, or several: lines and rings, those of polygons and in collections too. z is 0 where
          there is none. The attribute ``feature`` is the position of the geometry in a list or an array.
        - A ``GeoDataFrame`` or ``GeoSeries`` of geopandas: the same. Columns of numbers and texts become
          attributes, and ``frame.iloc[feature]`` is the row.
        - A ``Path3D`` of trimesh: each entity as a polyline, with the ``vertex_attributes`` where all of its points are
          vertices. Arcs and splines become polylines within the tolerance. z is 0 in a ``Path2D``, with a warning;
          ``path.to_3D(matrix)`` places its plane in space, without one.
        - A tuple of points, (m, 3), and offsets, (k + 1,) integers from 0 to m: strand i has the points from
          ``offsets[i]`` to ``offsets[i + 1]``. A pair of arrays that are both (m, 3) is two polylines.
        - A list, a tuple or an iterator of polylines, (m, 3) each: arrays or nested lists. Each is a strand, even if
          all have two points.
        - Segments without strands, (n, 2, 3) or (n, 6): a NumPy array, or what has ``__dlpack__`` or ``__array__``, as
          arrays of PyTorch, JAX and Arrow do.

        Points may have two coordinates, x and y, also in an array of segments (n, 2, 2); z is then 0, and a warning
        says so.

        Values by the name ``radius`` become the radius.
    offset : "auto" or three numbers, optional
        Subtracted from x, y and z in float64 before they are rounded to float32; see `fastlines.read`.
    invalid : {"error", "skip"}
        Refuse segments that hold NaN or Inf, or leave them out, as in `Lines.from_segments`.
    tolerance : float, optional
        How far the polylines of arcs and splines of a path of trimesh may be from these, in the unit of the
        coordinates; by default 10⁻⁵ of the longest side of the box of each. Choose one well below the radius of
        queries. What consists of straight lines is exact.

    Raises
    ------
    InputError
        If the object is none of these, or contradicts itself.

    Warns
    -----
    FileWarning
        Of everything that lines cannot hold, and of points whose z is taken as 0.

    Examples
    --------
    >>> import numpy as np
    >>> import fastlines as fl
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 5, 0], [1, 5, 0]])
    >>> fl.lines((points, [0, 3, 5])).strands
    array([0, 0, 1])
    >>> fl.lines([points[:3], points[3:]]).strands
    array([0, 0, 1])
    """
    choice("invalid", invalid, INVALID)
    told: list[str] = []
    if tolerance is not None:
        tolerance = number("tolerance", tolerance, "a length above 0", LEAST)
    made = _lines_of(obj, Making(invalid, check_offset(offset), told.append, tolerance))
    if isinstance(obj, Lines) and offset is not None and obj.offset != check_offset(offset):
        made = with_offset(obj, offset)
    for text in told:
        warn_caller(text, FileWarning)
    return made


def _lines_of(obj: Any, how: Making) -> Lines:
    """Make lines of an object."""
    if isinstance(obj, Lines):
        return obj
    if isinstance(obj, type):
        raise InputError(f"lines are a class, {obj.__name__}; expected an object of it")
    for of_others in (of_tractogram, of_neurons, of_mitsuba, of_vtk, of_features, of_path):
        if (made := of_others(obj, how)) is not None:
            return made
    if isinstance(obj, Iterator):
        return _lines_of(list(obj), how)
    if isinstance(obj, list | tuple) or (isinstance(obj, np.ndarray) and obj.dtype == object and obj.ndim == 1):
        return _of_list(obj, how)
    if has(obj, "control", "pieces"):
        raise InputError("lines are Curves; curves.pieces.lines are lines, and build takes curves as they are")
    if has(obj, "vertices", "faces"):
        raise InputError(
            f"lines are {kind_of(obj)}, a surface of triangles: fl.Triangles.from_mesh(mesh.vertices, mesh.faces) "
            "takes it"
        )
    if has(obj, "vertices", "bounds"):
        raise InputError(
            f"lines are {kind_of(obj)}, points without lines: fl.Spheres.from_centres(cloud.vertices, radius) takes "
            "these"
        )
    if has(obj, "geometry", "first_hit"):
        raise InputError(f"lines are {kind_of(obj)}; expected lines: pass tree.geometry, or save the tree by tree.save")
    array = to_array(obj)
    return as_lines(in_space(array, how) if _shape(array)[1:] == (2, 2) else array, **how.options)


def _of_list(obj: Any, how: Making) -> Lines:
    """Make lines of points and offsets, of polylines, or of nested numbers."""
    if isinstance(obj, tuple) and len(obj) == 2:
        points, offsets = (to_array(part) for part in obj)
        if np.ndim(points) == 2 and np.ndim(offsets) == 1:
            points = in_space(points, how) if _shape(points)[1] == 2 else points
            return _of_offsets(points, np.asarray(offsets), how)
    lead = next((part for part in map(to_array, obj) if _shape(part) not in ((0,), (0, 3))), None)
    shape = _shape(lead)
    if len(shape) != 2 or shape[1] not in (2, 3):
        return as_lines(obj, **how.options)
    parts = [to_array(part) for part in obj]
    if shape[1] == 2:
        parts = [with_z(part) if _shape(part)[1:] == (2,) else part for part in parts]
        how.warn(FLAT)
    return Lines.from_strands(parts, **how.options)


def _of_offsets(points: Any, offsets: AnyArray, how: Making) -> Lines:
    places = to_integers(offsets, "offsets")
    n = len(points)
    if not len(places) or places[0] != 0 or places[-1] != n or (np.diff(places) < 0).any():
        raise InputError(
            f"the offsets do not rise from 0 to the number of points, {n}; expected one more than there are strands; "
            "of numbers of points, Lines.from_points makes lines"
        )
    return Lines.from_points(points, np.diff(places), **how.options)


def _shape(part: Any) -> tuple[int, ...]:
    try:
        return np.shape(part)
    except ValueError:  # its parts differ in length
        return ()
