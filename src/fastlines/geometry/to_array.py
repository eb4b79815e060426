"""Arrays of other libraries as arrays of NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import kind_of
from ..errors import InputError
from .making import has


def to_array(obj: Any) -> Any:
    """Return what can be read as an array as one, sharing memory where its library allows it; else the object."""
    if isinstance(obj, np.ndarray | str) or not (has(obj, "__dlpack__") or has(obj, "__array__")):
        return obj
    if has(obj, "type", "flatten") and hasattr(obj.type, "list_size"):  # a list of fixed size of Arrow
        if obj.null_count:
            raise InputError(f"{kind_of(obj)} has {obj.null_count} nulls; fill them, or leave their rows out")
        inner = np.asarray(to_array(obj.flatten()))
        return inner.reshape(len(obj), obj.type.list_size, *inner.shape[1:])
    if has(obj, "__dlpack__"):
        try:
            return np.from_dlpack(obj)
        except Exception as error:  # on another device, with gradients, of another type: each library has its own
            if not has(obj, "__array__"):
                raise _unreadable(obj, error) from None
    try:
        return np.asarray(obj)
    except Exception as error:
        raise _unreadable(obj, error) from None


def _unreadable(obj: object, error: Exception) -> InputError:
    why = " ".join(str(error).split())[:120]
    return InputError(f"{kind_of(obj)} cannot be read as an array ({why}); detach it, or copy it to the CPU first")
