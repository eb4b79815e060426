"""Arbitrary output variables (AOVs): what one ray through the centre of each pixel hits, as numbers.

They are not averaged over samples, so that edges stay sharp and ids stay ids. Lines thinner than a pixel have no
surfaces to hit. Of them a pixel has the nearest one within half a pixel of its ray.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray
from ...query.hits import FirstHits
from ...support.vectors import across
from .depth import MAX_RAYS, bands
from .shading_context import ShadingContext

#: The AOVs, and what each one holds.
AOVS = {
    "depth": "the distance from the camera along the ray; inf where nothing is hit",
    "position": "the point of the ray; NaN where nothing is hit",
    "normal": "the unit normal, outwards; NaN where nothing is hit",
    "tangent": "the unit direction of the line from its start to its end; NaN for what has none",
    "id": "the strand, or the primitive of what has no strand; -1 where nothing is hit",
    "prim": "the primitive, counted over all parts of the geometry; -1 where nothing is hit",
}


def find_aovs(context: ShadingContext, width: int, height: int) -> dict[str, AnyArray]:
    """Return the AOVs of a picture, as `AOVS` describes them.

    Returns
    -------
    dict of str to array
        (height, width) float32 for "depth"; (height, width, 3) float32 for "position", "normal" and "tangent", in the
        coordinates of the scene; (height, width) int64 for "id" and "prim". In a picture of lines with an offset, the
        position is float64.

    Examples
    --------
    >>> import fastlines as fl
    >>> camera = fl.Camera(origin=(0, 0, 4), target=(0, 0, 0))
    >>> picture = fl.render([[[-9, 0, 0], [9, 0, 0]]], camera, width=3, height=3, radius=0.5, aovs=True)
    >>> print(picture.aovs["depth"][:, 1], picture.aovs["id"][:, 1], picture.aovs["normal"][1, 1])
    [inf 3.5 inf] [-1  0 -1] [0. 0. 1.]
    """
    found: dict[str, AnyArray] = {
        "depth": np.empty((height, width), np.float32),
        **{name: np.empty((height, width, 3), np.float32) for name in ("position", "normal", "tangent")},
        **{name: np.empty((height, width), np.int64) for name in ("id", "prim")},
    }
    origin = np.asarray(context.camera.origin, np.float32)
    for rows in bands(width, height, MAX_RAYS):
        directions = context.camera.directions(width, height, rows)
        spread = context.camera.spread(height) if context.thin else 0.0
        at = "closest" if context.thin else "surface"
        hits = context.tree.first_hit(origin, directions, context.radius, spread=spread, at=at)
        tangents = hits.tangents()
        found["depth"][rows] = hits.t
        found["position"][rows] = hits.points()
        found["normal"][rows] = _across(hits, tangents, directions) if context.thin else hits.normals()
        found["tangent"][rows] = tangents
        found["id"][rows] = np.where(hits.strand >= 0, hits.strand, hits.prim)
        found["prim"][rows] = hits.prim_number
    return found


def _across(hits: FirstHits, tangents: npt.NDArray[np.float64], directions: FloatArray) -> AnyArray:
    """Return the way to the eye across each line, which stands for the normal of a line that is too thin to have one.

    Where a line has no direction or points to the eye, it is the way to the eye.
    """
    to_eye = -directions.reshape(-1, 3)
    normals = across(np.nan_to_num(tangents).reshape(-1, 3), to_eye)[2].reshape(directions.shape)
    normals = np.where((normals**2).sum(axis=-1, keepdims=True) > 0.5, normals, -directions)
    return np.where(hits.hit[..., None], normals, np.float32(np.nan))
