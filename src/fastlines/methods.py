"""The named trees as a mapping that explains itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .settings import Settings


class Methods(Mapping[str, "Settings"]):
    """The named trees: the `Settings` that `build` has for each name. They can not be changed.

    ========  ==========================================================================================
    best      the default, the tree that queries are fastest on; with a cost or cut boxes, of least cost
    bvh-cl    BVH over whole primitives, SAH
    bvh-ss    BVH over primitives that are cut by a grid of planes, SAH
    bvh-d2    as bvh-ss; where SAH says leaf, it looks two levels ahead
    kd-cl     KD tree over a grid of planes, SAH
    kd-d2     as kd-cl; where SAH says leaf, it looks two levels ahead
    ========  ==========================================================================================

    All but "best" are those of the thesis (§5). Of "best" these are the settings for small inputs: `build` suits them
    to the input and to what it is told.

    Examples
    --------
    >>> import fastlines as fl
    >>> list(fl.METHODS)
    ['best', 'bvh-cl', 'bvh-ss', 'bvh-d2', 'kd-cl', 'kd-d2']
    >>> fl.METHODS["kd-d2"].lookahead
    (1, 2)
    """

    def __init__(self, settings: Mapping[str, Settings]) -> None:
        self._settings = dict(settings)

    def __getitem__(self, method: str) -> Settings:
        return self._settings[method]

    def __iter__(self) -> Iterator[str]:
        return iter(self._settings)

    def __len__(self) -> int:
        return len(self._settings)

    def __repr__(self) -> str:
        return f"<Methods: {', '.join(self)}>"
