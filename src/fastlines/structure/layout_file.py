"""The layout of a tree as sections and metadata of a file, and back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..geometry.any_geometry import AnyGeometry
from ..support.container import Arrays
from .layout import BLOCK, Layout

#: What the sections of a layout begin with, and the key of its metadata.
PREFIX, KEY = "layout/", "layout"

#: The form of the blocks. Layouts of another form are not read: the tree is laid out anew.
FORM = 1

#: The blocks, which come first in a file, so that they are aligned; then the references.
SECTIONS: dict[str, tuple[str, int]] = {"nodes": ("u1", BLOCK), "leaves": ("u1", BLOCK), "refs": ("<u4", 2)}


def to_sections(layout: Layout) -> tuple[Arrays, dict[str, str]]:
    """Return the sections and the metadata of a layout."""
    arrays = {PREFIX + name: np.asarray(getattr(layout, name)) for name in SECTIONS}
    facts: dict[str, Any] = {"form": FORM, "mean_extent": layout.mean_extent}
    for name in layout.geometry.derived:
        value = getattr(layout.geometry, name)
        if isinstance(value, np.ndarray):
            arrays[PREFIX + name] = value
        else:
            facts[name] = value
    return arrays, {KEY: json.dumps(facts)}


def from_sections(
    arrays: Arrays,
    metadata: Mapping[str, str],
    geometry: AnyGeometry,
    box: npt.NDArray[np.float32],
    frame: npt.NDArray[np.float32] | None,
    trusted: bool,
) -> Layout | None:
    """Return the layout of a file, if it has one; unless it is trusted, check that no query can crash on it.

    Raises
    ------
    ValueError
        If it is not a usable layout.
    """
    facts = json.loads(metadata.get(KEY, "{}"))
    if facts.get("form") != FORM:
        return None
    found: dict[str, Any] = {}
    for name, (dtype, width) in SECTIONS.items():
        array = arrays.get(PREFIX + name)
        if array is None or array.dtype != np.dtype(dtype) or array.shape[1:] != (width,):
            raise ValueError(f"the section {PREFIX + name!r} is missing or has another shape or type")
        found[name] = array
    for name in geometry.derived:
        value = arrays[PREFIX + name] if PREFIX + name in arrays else facts[name]
        if not trusted and not np.array_equal(value, getattr(geometry, name)):
            raise ValueError(f"{name} of its layout are not those of its lines")
        geometry.__dict__[name] = value
    mean_extent = float(facts["mean_extent"])
    if not 0 <= mean_extent < np.inf:
        raise ValueError(f"the mean extent of its layout is {mean_extent}")
    layout = Layout(geometry, box, **found, mean_extent=mean_extent, frame=frame)
    fault = None if trusted else _core.check_layout(layout.view)
    if fault is not None:
        raise ValueError(fault)
    return layout
