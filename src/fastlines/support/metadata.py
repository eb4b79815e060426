"""Metadata: what is known of a whole container, beside its arrays. It holds what JSON holds, and is read-only."""

from __future__ import annotations

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ..errors import InputError

#: The most levels of lists and mappings within each other.
MAX_DEPTH = 32


def read_only(metadata: Any) -> Mapping[str, Any]:
    """Return a read-only copy of a mapping: lists and arrays become tuples, and mappings are read-only too.

    Examples
    --------
    >>> read_only({"grid": {"size": [1, 2.5]}})["grid"]["size"]
    (1, 2.5)
    """
    if not isinstance(metadata, Mapping):
        raise InputError(f"metadata are a {type(metadata).__name__}; expected a mapping of names to values")
    made = _read_only(metadata, "metadata", MAX_DEPTH)
    assert isinstance(made, Mapping)
    return made


def _read_only(value: Any, name: str, depth: int) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if value is None or isinstance(value, str | bool | int | float):
        return value
    if not depth:
        raise InputError(f"{name}: lists and mappings are nested more than {MAX_DEPTH} levels deep; flatten them")
    if isinstance(value, list | tuple):
        return tuple(_read_only(part, f"{name}[{i}]", depth - 1) for i, part in enumerate(value))
    if not isinstance(value, Mapping):
        raise InputError(
            f"{name} is a {type(value).__name__}; expected what JSON holds (a text, a number, True or False, None, a "
            "list or a mapping of these), or an array"
        )
    for key in value:
        if not isinstance(key, str):
            raise InputError(f"{name} has the name {key!r}, a {type(key).__name__}; expected a text")
    return MappingProxyType({key: _read_only(part, f"{name}[{key!r}]", depth - 1) for key, part in value.items()})


def to_json(metadata: Any) -> str:
    """Return metadata as JSON.

    Examples
    --------
    >>> to_json(read_only({"grid": {"size": [1, 2.5]}}))
    '{"grid": {"size": [1, 2.5]}}'
    """
    return json.dumps(metadata, default=dict)


def from_json(text: str) -> Mapping[str, Any]:
    """Return metadata from JSON, or raise an InputError.

    Examples
    --------
    >>> from_json('{"offset": [1, 2, 3]}')["offset"]
    (1, 2, 3)
    """
    try:
        return read_only(json.loads(text))
    except InputError:
        raise
    except (ValueError, RecursionError):  # broken, too deep, or a number of too many digits
        raise InputError("they are not a mapping in JSON") from None
