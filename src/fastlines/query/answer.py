"""What all answers of queries share: copies, which keep the geometry, and pickles, which leave it out."""

from __future__ import annotations

import copy
from typing import Any, ClassVar, TypeVar

from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..support.display import Shown
from ..support.immutable import own

Self = TypeVar("Self", bound="Answer")


class Answer(Shown):
    """An answer about a geometry."""

    geometry: AnyGeometry | None

    #: The fields that pickles leave out, besides what is computed once from them.
    _unpickled: ClassVar[tuple[str, ...]] = ("geometry",)

    #: What is computed once from the geometry. Pickles have it in its place.
    _in_pickles: ClassVar[tuple[str, ...]] = ()

    def _known(self) -> AnyGeometry:
        if self.geometry is None:
            kept = " and ".join(f"`{name}`" for name in self._in_pickles)
            raise InputError(f"this answer does not know its geometry: a pickle has {kept} in its place; query again")
        return self.geometry

    def __copy__(self: Self) -> Self:
        copied = object.__new__(type(self))
        copied.__dict__.update(self.__dict__)
        return copied

    def __deepcopy__(self: Self, memo: dict[int, Any]) -> Self:
        copied = copy.copy(self)
        shared = (*self._unpickled, *self._in_pickles)  # which no answer changes
        copied.__dict__.update({k: copy.deepcopy(v, memo) for k, v in self.__dict__.items() if k not in shared})
        return copied

    def __getstate__(self) -> dict[str, Any]:
        known = {name: getattr(self, name) for name in self._in_pickles} if self.geometry is not None else {}
        return self.__dict__ | known | dict.fromkeys(self._unpickled)

    def __setstate__(self, state: dict[str, Any]) -> None:
        frozen = {name: own(state[name]) for name in self._in_pickles if name in state}
        self.__dict__.update(state | frozen)
