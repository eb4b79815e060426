"""A tree with the layout that its queries run on, on the CPU or on a GPU."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from ..structure.layout import Layout, build_layout
from ..structure.tree_data import TreeData
from ..support.computed_once import computed_once
from .choice import check_backend, device, get_backend

if TYPE_CHECKING:
    from .backend import CudaBackend

Self = TypeVar("Self", bound="PlacedTree")


@dataclass(frozen=True, eq=False, repr=False)
class PlacedTree(TreeData):
    """A tree, its layout, and the backend that answers its queries."""

    def __getstate__(self) -> dict[str, Any]:
        return super().__getstate__() | ({"layout": self.layout} if "layout" in self.__dict__ else {})

    @computed_once
    def layout(self) -> Layout:
        """The wide layout, which queries run on; built on the first query, and kept."""
        return build_layout(self.geometry, *self.words(), self.box, frame=self.frame)

    def to(self: Self, backend: str) -> Self:
        """Return this tree with a backend that answers its queries: "cpu" or "cuda".

        Answers are the same. The layout is uploaded to the GPU once, for the first query. A tree that is not placed
        has the backend of `set_backend`; so has a tree from a file or from a refit.

        Parameters
        ----------
        backend : {"cpu", "cuda"}

        Raises
        ------
        MissingExtraError
            If the extra "cuda" is not installed.
        FastlinesError
            If there is no GPU, or no driver.
        InputError
            If the tree is over a class of your own.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
        >>> tree.to("cpu").backend
        'cpu'
        """
        if check_backend(backend) == "cuda":
            self.geometry.require_gpu()
            _ = self.layout  # so that all trees made from this one share it, and it is uploaded once
        placed = object.__new__(type(self))
        placed.__dict__.update(self.__dict__)
        placed.__dict__["_place"] = backend
        return placed

    @property
    def backend(self) -> str:
        """Which backend answers queries: "cpu" or "cuda"."""
        return str(self.__dict__.get("_place") or get_backend())

    def _on_gpu(self, has_spread: bool, parts: tuple[int, ...] | None = None, *, alone: bool = False) -> CudaBackend:
        """Return the backend that queries the GPU.

        Rays in the memory of the GPU are answered by it `alone`: it is an error if that is not possible.
        """
        from .backend import CudaBackend
        from .scene import require_cuda, scene_of

        if alone:
            require_cuda(self.backend, self.geometry)
        return CudaBackend(scene_of(self.layout, device(), has_spread, parts))
