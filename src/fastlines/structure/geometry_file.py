"""The geometry of a tree as sections and metadata of a file, and back.

Sections of lines have the names of the fields of `Lines`; attributes have a prefix. Of a `Geometry`, those of part 1
begin with ``parts/1/``. The metadata of a container has its kind, and everything that is not an array. An attribute of
texts is a section of numbers of texts, and the different texts are a section ``texts/…``, the bytes of a list in JSON.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy as np

from ..arrays import is_text
from ..errors import InputError
from ..geometry import kinds
from ..geometry.any_geometry import AnyGeometry
from ..geometry.collection import Geometry
from ..geometry.lines import Lines
from ..support import container
from ..support.container import Arrays
from ..support.text_columns import TEXTS, numbered, texts_of

#: The mappings of attributes of a container, and what their sections begin with.
ATTRIBUTES = ("attributes", "end_attributes", "corner_attributes")
#: What is known of a container beside its arrays and its metadata.
FACTS = ("up", "unit", "tolerance")

Refuse: TypeAlias = Callable[[str], Exception]


def to_sections(geometry: AnyGeometry) -> tuple[Arrays, dict[str, Any], list[str]]:
    """Return the sections and the metadata of a geometry, and the attributes that a file cannot keep."""
    if geometry.has_parts:
        arrays: Arrays = {}
        parts, all_lost = [], []
        for i, part in enumerate(geometry.each_part()):
            sections, facts, lost = to_sections(part)
            arrays |= {f"parts/{i}/{name}": array for name, array in sections.items()}
            parts.append(facts)
            all_lost += lost
        return arrays, {"kind": Geometry.__name__, "parts": parts}, all_lost
    name = type(geometry).__name__
    if kinds.KINDS.get(name) is not type(geometry):
        known = ", ".join([*kinds.KINDS, Geometry.__name__])
        other = "" if geometry.has_user_code else f", or add {name} to KINDS of {kinds.__name__}"
        raise InputError(f"files keep trees over {known}, and this one is over {name}; use pickle{other}")
    arrays = {key: getattr(geometry, key) for key in geometry.sections if getattr(geometry, key) is not None}
    if not len(arrays.get("skipped", ())):
        arrays.pop("skipped", None)
    facts = {key: getattr(geometry, key, None) for key in FACTS} | {"metadata": geometry.metadata or None}
    kept, lost = _attributes(geometry)
    return arrays | kept, {"kind": name, **facts}, lost


def _attributes(geometry: Any) -> tuple[Arrays, list[str]]:
    """Name the sections of the attributes, and describe those that a file cannot keep."""
    ends: Mapping[str, Any] = getattr(geometry, "end_attributes", {})
    arrays = {
        f"{kind}/{name}": values
        for kind in ATTRIBUTES
        for name, values in getattr(geometry, kind, {}).items()
        if kind != "attributes" or name not in ends  # which is that of the first end
    }
    for name in [name for name, values in arrays.items() if is_text(values) and values.ndim <= 3]:
        arrays[name], arrays[TEXTS + name] = numbered(arrays[name])
    little = {name: values.astype(values.dtype.newbyteorder("<"), copy=False) for name, values in arrays.items()}
    kept = {name: values for name, values in little.items() if values.dtype in container.NAMES and values.ndim <= 3}
    lost = [
        f"{name.partition('/')[2]!r} ({values.dtype}, {values.ndim}-d)"
        for name, values in little.items()
        if name not in kept
    ]
    return kept, lost


def from_sections(arrays: Arrays, facts: Mapping[str, Any], refuse: Refuse, *, trusted: bool = False) -> AnyGeometry:
    """Return the geometry of a file, or raise what `refuse` returns. Of a `trusted` file, not each row is checked."""
    kind = facts.get("kind") or Lines.__name__
    if kind == Geometry.__name__:
        parts = []
        for i, part in enumerate(facts["parts"]):
            prefix = f"parts/{i}/"
            own = {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
            if part.get("kind") == Geometry.__name__:
                raise refuse("a part of its geometry has parts")
            parts.append(from_sections(own, part, refuse, trusted=trusted))
        return Geometry(parts)
    if kind not in kinds.KINDS:
        raise refuse(f"it is over {kind!r}, expected one of {', '.join([*kinds.KINDS, Geometry.__name__])}")
    given: dict[str, Any] = {}
    for name, (dtype, rows, is_needed) in kinds.KINDS[kind].sections.items():
        if name not in arrays and not is_needed:
            continue
        if name not in arrays or arrays[name].ndim == 0 or arrays[name].shape[1:] not in rows:
            raise refuse(f"the section {name!r} is missing or has another shape")
        if arrays[name].dtype != np.dtype(dtype):
            raise refuse(f"the section {name!r} has another type")
        given[name] = arrays[name]
    for mapping in ATTRIBUTES:
        prefix = f"{mapping}/"
        found = {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
        found |= {
            name: texts_of(values, arrays[TEXTS + prefix + name])
            for name, values in found.items()
            if TEXTS + prefix + name in arrays
        }
        if found:
            given[mapping] = found
    given |= {key: facts[key] for key in (*FACTS, "metadata") if facts.get(key) is not None}
    made: Callable[..., AnyGeometry] = kinds.KINDS[kind].restored if trusted else kinds.KINDS[kind]
    return made(**given)
