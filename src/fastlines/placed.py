"""Where the queries of a tree are answered: on the CPU or on a GPU."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

from .cuda.choice import check_backend, get_backend
from .cuda.scene import require_primitives
from .tree_data import TreeData

Self = TypeVar("Self", bound="PlacedTree")


@dataclass(frozen=True, eq=False, repr=False)
class PlacedTree(TreeData):
    """A tree, and the backend that answers its queries."""

    def to(self: Self, backend: str) -> Self:
        """Return this tree with a backend that answers its queries: "cpu" or "cuda" (docs/gpu.md).

        Answers are the same. The layout is uploaded to the GPU once, for the first query. A tree that is not placed
        has the backend of `set_backend`; so has a tree from a file or from a refit.

        Parameters
        ----------
        backend : {"cpu", "cuda"}

        Raises
        ------
        MissingExtraError
            If the extra ``fastlines[cuda]`` is not installed.
        FastlinesError
            If there is no GPU, or no driver.
        InputError
            If the tree is over something that the GPU does not know.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
        >>> tree.to("cpu").backend
        'cpu'
        """
        if check_backend(backend) == "cuda":
            require_primitives(self.geometry)
        placed = object.__new__(type(self))
        placed.__dict__.update(self.__dict__)
        placed.__dict__["_backend"] = backend
        return placed

    @property
    def backend(self) -> str:
        """Which backend answers queries: "cpu" or "cuda"."""
        return str(self.__dict__.get("_backend") or get_backend())
