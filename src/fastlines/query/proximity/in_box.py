"""The primitives in boxes, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass

from ...arrays import IntArray
from ...errors import InputError
from ...geometry.any_geometry import AnyGeometry
from ...support.distinct import distinct
from ...support.texts import counted
from ..compressed_rows import CompressedRows
from ..prim_numbers import PrimNumbers


@dataclass(frozen=True, eq=False, repr=False)
class InBox(CompressedRows, PrimNumbers):
    """The primitives that have a point in each box, each once, sorted by (box, part, prim).

    Those of box i are entries ``offsets[i]`` to ``offsets[i + 1]`` of the other arrays (compressed sparse rows).

    Attributes
    ----------
    offsets : (n_boxes + 1,) int64
        The first entry of each box, in the order of the flattened input, and the end of the last.
    prim : int64
        The index of each segment, curve, triangle or other primitive, rising.
    geometry : Lines, Geometry or another container, or None
        What the tree is over. A pickle leaves it out, and keeps `row` and `strand`.
    part : int64 or None
        The part of a `Geometry`; `prim` counts within it. None for a single container.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.Lines.from_strands([[[0, 0, 0], [2, 0, 0], [4, 0, 0]], [[0, 5, 0], [4, 5, 0]]]))
    >>> found = tree.in_box([[1, -1, -1], [1, -1, -1]], [[3, 1, 1], [1.5, 9, 1]])
    >>> print(found.offsets, found.prim, found.box, found.strands(0), found.strands())
    [0 2 4] [0 1 0 2] [0 0 1 1] [0] [0 1]
    """

    offsets: IntArray
    prim: IntArray
    geometry: AnyGeometry | None = None
    part: IntArray | None = None

    def __repr__(self) -> str:
        return f"<InBox: {counted(len(self.offsets) - 1, 'boxes')}, {counted(len(self), 'primitives')}>"

    @property
    def box(self) -> IntArray:
        """The index of the box of each entry, (n_entries,) int64."""
        return self._row_of_entries

    def of(self, box: int) -> slice:
        """Return the slice of the entries of a box: ``found.prim[found.of(3)]``.

        Raises
        ------
        InputError
            If there is no such box; boxes count from 0.
        """
        return self._entries_of("box", box)

    def strands(self, box: int | None = None) -> IntArray:
        """Return the different strands in a box, or in any of the boxes, rising, as `Lines.select` takes them.

        Raises
        ------
        InputError
            If there is no such box; or for a `Geometry`, whose parts count their own strands.
        """
        if self.part is not None:
            raise InputError(
                "each part of a Geometry counts its own strands; use strand, where part is the one you want"
            )
        strand = self.strand if box is None else self.strand[self.of(box)]
        return distinct(strand[strand >= 0])
