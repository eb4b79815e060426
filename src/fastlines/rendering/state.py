"""The state of an unfinished picture as a file, and the settings to which it belongs."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import zipfile
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import AnyArray
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..support.atomic_write import atomic_write

#: The format of the file; another order of samples would be another format.
FORMAT = "fastlines picture 1"


def write_state(path: str | os.PathLike[str], settings: Mapping[str, str], arrays: Mapping[str, AnyArray]) -> None:
    """Write settings and arrays as .npz; the file appears whole or not at all."""
    text = np.array(json.dumps({"format": FORMAT, **settings}))
    columns: dict[str, Any] = {"settings": text, **arrays}
    with atomic_write(path) as partial, partial.open("wb") as file:
        np.savez(file, **columns)


def read_state(
    path: str | os.PathLike[str], settings: Mapping[str, str], arrays: Mapping[str, AnyArray]
) -> dict[str, AnyArray]:
    """Read the arrays of a state.

    Parameters
    ----------
    path : str or path
    settings : mapping of str to str
        Those that the state must have.
    arrays : mapping of str to array
        Arrays of the expected shapes and types.

    Raises
    ------
    InputError
        If the file is not the state of a picture, or is that of one with other settings, which the message names.
    OSError
        If it cannot be read.
    """
    try:
        with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
            found = {name: file[name] for name in file.files}
        known = json.loads(str(found.pop("settings")))
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile):
        raise InputError(
            f"{path}: is not the state of a picture; expected the .npz file that an unfinished picture was saved to"
        ) from None
    if not isinstance(known, dict) or known.pop("format", None) != FORMAT:
        raise InputError(f"{path}: is not a state of this version of fastlines; render from the start")
    others = [name for name, value in settings.items() if known.get(name) != value]
    if others:
        told = "; ".join(_difference(name, str(known.get(name)), settings[name]) for name in others)
        raise InputError(f"{path}: is the state of another picture: {told}; use the same options, or start again")
    for name, array in arrays.items():
        if name not in found or found[name].shape != array.shape or found[name].dtype != array.dtype:
            raise InputError(f"{path}: is damaged: {name} are not as they were written; render from the start")
    return found


def _difference(name: str, was: str, now: str) -> str:
    """Say how a setting differs, where that is short enough to be read."""
    return f"{name} was {was}, and is {now}" if len(was) + len(now) < 60 else f"the {name} differs"


def digest(geometry: AnyGeometry) -> str:
    """Return a checksum of all that a picture can show of a geometry: shapes, strands and attributes.

    Examples
    --------
    >>> import fastlines as fl
    >>> one, other = (fl.lines([[[0, 0, 0], [x, 1, 1]]]) for x in (1, 2))
    >>> digest(one) == digest(one), digest(one) == digest(other)
    (True, False)
    """
    found = hashlib.blake2b(digest_size=16)
    found.update(np.ascontiguousarray(geometry.core_rows).tobytes())
    for part in geometry.each_part():
        found.update(f"{type(part).__name__} {len(part)}".encode())
        for columns in ("attributes", "end_attributes", "corner_attributes"):
            for name, values in getattr(part, columns, {}).items():
                found.update(f"{columns} {name} {values.dtype}".encode())
                found.update(repr(values.tolist()).encode() if values.dtype == object else values.tobytes())
        found.update(np.asarray(getattr(part, "strands", ())).tobytes())
    return found.hexdigest()


def describe(value: Any) -> str:
    """Write a setting as text that is the same in another process, unlike the `repr` of a function.

    Examples
    --------
    >>> from fastlines.rendering.shading.lighting import Light
    >>> describe(Light(direction=(0, 0, 1)))
    'Light(direction=(0.0, 0.0, 1.0), color=(1.0, 1.0, 1.0), angle=2.0)'
    >>> describe(describe)
    'fastlines.rendering.state.describe'
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = (f"{f.name}={describe(getattr(value, f.name))}" for f in dataclasses.fields(value))
        return f"{type(value).__name__}({', '.join(fields)})"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(describe, value))})"
    if isinstance(value, np.ndarray):
        return describe(value.tolist())
    if isinstance(value, dict):
        return f"({', '.join(f'{name}={describe(of)}' for name, of in sorted(value.items()))})"
    kind: Any = type(value)
    if kind.__repr__ is object.__repr__:
        return f"{kind.__name__}{describe(getattr(value, '__dict__', {}))}"
    if hasattr(value, "__qualname__"):
        return f"{value.__module__}.{value.__qualname__}"
    return repr(value.item() if isinstance(value, np.generic) else value)
