"""Immutable memory: which arrays can be shared, and which are copied first."""

from __future__ import annotations

import mmap
from collections.abc import Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any, ClassVar, TypeVar

import numpy as np
import numpy.typing as npt

Self = TypeVar("Self")


class _Owner:
    """Owns memory and exposes it read-only: NumPy cannot make an array writeable whose base this is."""

    def __init__(self, array: npt.NDArray[Any]) -> None:
        self.array = array
        shown = array.reshape(-1).view(np.uint8).__array_interface__
        self.__array_interface__ = {**shown, "data": (shown["data"][0], True)}


class Immutable:
    """Base of immutable dataclasses: a copy is the object itself, and unpickled objects are immutable too."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __copy__(self: Self) -> Self:
        return self

    def __deepcopy__(self: Self, memo: dict[int, Any]) -> Self:
        return self

    @property
    def derived(self) -> tuple[str, ...]:
        """The names of what is computed once of all parts, and takes long enough that files keep it."""
        return ()

    @classmethod
    def restored(cls: type[Self], **given: Any) -> Self:
        """Make an object of parts that were checked before, as far as its class can without a look at each."""
        return cls(**given)

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: _thawed(getattr(self, field.name)) for field in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, frozen(value))


def frozen(value: Any) -> Any:
    """Return an immutable array, or a mapping or a tuple of such arrays; writeable memory is copied."""
    if isinstance(value, Mapping):
        return MappingProxyType({name: frozen(part) for name, part in value.items()})
    if type(value) is tuple:
        return tuple(frozen(part) for part in value)
    if not isinstance(value, np.ndarray) or (value.flags.aligned and _is_immutable(value)):
        return value
    return own(np.array(value, order="C"))


def _thawed(value: Any) -> Any:
    """Return a value whose mappings are dictionaries, which can be pickled."""
    if isinstance(value, Mapping):
        return {name: _thawed(part) for name, part in value.items()}
    return tuple(_thawed(part) for part in value) if type(value) is tuple else value


def own(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Make an array immutable without a copy; the caller must hold the only reference to it."""
    if array.dtype.hasobject or array.dtype.itemsize == 0:  # NumPy cannot view bytes as these types
        array.flags.writeable = False
        return array
    array = array if array.flags.c_contiguous else array.copy()
    return np.asarray(_Owner(array)).view(array.dtype).reshape(array.shape)


def _is_immutable(array: npt.NDArray[Any]) -> bool:
    """Return whether the owner of an array's memory is read-only: `_Owner`, bytes or a read-only map."""
    base: Any = array
    while isinstance(base, np.ndarray):
        if base.flags.writeable:
            return False
        base = base.base
    while isinstance(base, memoryview):
        base = base.obj
    if isinstance(base, mmap.mmap):
        return memoryview(base).readonly
    return isinstance(base, bytes | _Owner)
