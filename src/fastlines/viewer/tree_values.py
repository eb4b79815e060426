"""What a tree makes of each primitive: how deep it lies, in how large a leaf, and what share of the cost it has."""

from __future__ import annotations

import numpy as np

from ..geometry.any_geometry import AnyGeometry
from ..geometry.hit_places import Float64Array
from ..inspection.outline import Outline

#: The values by name, and what they are, in words.
TREE_VALUES = {
    "depth": "level of the leaf; the mean over all references",
    "leaf size": "references in the leaf; the mean over all references",
    "cost": "share of the cost of all leaves, relative to the mean",
}


def tree_values(outline: Outline, geometry: AnyGeometry, name: str) -> Float64Array:
    """Return a value of `TREE_VALUES` for each primitive, (n,); NaN for one without a reference.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.inspection import outline_of
    >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]], "bvh-cl", cost=fl.Cost(0.1))
    >>> tree_values(outline_of(tree), tree.geometry, "depth")
    array([1., 1.])
    """
    leaves = np.flatnonzero(outline.is_leaf & (outline.n_refs > 0))
    leaves = leaves[np.argsort(outline.first_ref[leaves], kind="stable")]
    n_refs = outline.n_refs[leaves]
    if name == "depth":
        of_leaves = outline.level[leaves].astype(np.float64)
    elif name == "leaf size":
        of_leaves = n_refs.astype(np.float64)
    else:
        of_leaves = len(geometry) * outline.own_cost[leaves] / (n_refs * outline.own_cost[leaves].sum())
    prims = geometry.owner[outline.prims]
    total = np.bincount(prims, np.repeat(of_leaves, n_refs), minlength=len(geometry))
    if name == "cost":
        return np.asarray(total, np.float64)
    count = np.bincount(prims, minlength=len(geometry))
    return np.asarray(np.divide(total, count, out=np.full(len(geometry), np.nan), where=count > 0))
