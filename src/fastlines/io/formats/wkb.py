"""Well-known binary: the line strings in geometries, as arrays of points.

Format: OGC 06-103r4, section 8 (https://www.ogc.org/standard/sfa/), whose types are 1000, 2000 or 3000 larger with z, m
or both; and PostGIS's flags for these and for a reference system. The parts of a geometry follow it, each with a header
of its own.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray

Float64Array = npt.NDArray[np.float64]

#: The names of types, by number.
_NAMES = {
    1: "POINT", 2: "LINESTRING", 3: "POLYGON", 4: "MULTIPOINT", 5: "MULTILINESTRING", 6: "MULTIPOLYGON",
    7: "GEOMETRYCOLLECTION", 8: "CIRCULARSTRING", 9: "COMPOUNDCURVE", 10: "CURVEPOLYGON", 11: "MULTICURVE",
    12: "MULTISURFACE", 15: "POLYHEDRALSURFACE", 16: "TIN", 17: "TRIANGLE",
}  # fmt: skip
_LINE, _LINES = 2, (2, 5, 7)
#: Types by what follows their header: points, rings of points, geometries.
_POINTS, _RINGS, _PARTS = (2, 8), (3, 17), (4, 5, 6, 7, 9, 10, 11, 12, 15, 16)
_Z, _M, _SRID = 0x80000000, 0x40000000, 0x20000000


@dataclass
class Wkb:
    """Line strings that are found in geometries, not yet converted to numbers.

    Attributes
    ----------
    parts : list of bytes
        The numbers of each line string.
    kinds : list of (str, bool, bool)
        Their byte order, and whether each point has z and m.
    rows : list of int
        The row of each line string.
    others : dict
        How many geometries of each other type there are.
    """

    parts: list[bytes] = field(default_factory=list)
    kinds: list[tuple[str, bool, bool]] = field(default_factory=list)
    rows: list[int] = field(default_factory=list)
    others: dict[str, int] = field(default_factory=dict)

    def add(self, data: bytes, row: int) -> None:
        """Find the line strings of a geometry; raise a ValueError if it is none."""
        at, n_left = 0, 1
        while n_left:
            n_left -= 1
            at, n_parts = self._add(data, at, row)
            # Each part has a header of 5 bytes or more.
            n_left += n_parts
            if 5 * n_left > len(data) - at:
                raise ValueError("it is cut short")
        if at != len(data):
            raise ValueError(f"{len(data) - at} bytes are left over")

    def _add(self, data: bytes, at: int, row: int) -> tuple[int, int]:
        """Read a geometry without its parts; return where it ends, and how many parts follow."""
        if len(data) < at + 5 or data[at] > 1:
            raise ValueError("it does not begin with a byte order and a type")
        order = "<" if data[at] else ">"
        code = int(struct.unpack_from(f"{order}I", data, at + 1)[0])
        at += 5 + 4 * bool(code & _SRID)
        kind, dims = (code & 0xFFFF) % 1000, (code & 0xFFFF) // 1000
        has_z, has_m = bool(code & _Z) or dims in (1, 3), bool(code & _M) or dims in (2, 3)
        if kind not in _NAMES or dims > 3:
            raise ValueError(f"its type is {code:#x}, of no geometry")
        if kind not in _LINES:
            self.others[_NAMES[kind]] = self.others.get(_NAMES[kind], 0) + 1
        size = 8 * (2 + has_z + has_m)
        if kind == 1:
            return _within(data, at + size), 0
        n, at = _count(data, at, order)
        if kind in _PARTS:
            return at, n
        if kind in _POINTS:
            end = _within(data, at + n * size)
            if kind == _LINE and n:
                self.parts.append(data[at:end])
                self.kinds.append((order, has_z, has_m))
                self.rows.append(row)
            return end, 0
        for _ in range(n):
            n_points, at = _count(data, at, order)
            at = _within(data, at + n_points * size)
        return at, 0

    def arrays(self) -> tuple[Float64Array, IntArray, Float64Array | None]:
        """Return the points (m, 3), the number of points of each line string, and m of each point, if any has it."""
        known = {kind: i for i, kind in enumerate(dict.fromkeys(self.kinds))}
        which = np.array([known[kind] for kind in self.kinds], np.int64)
        sizes = np.array([8 * (2 + has_z + has_m) for _, has_z, has_m in known], np.int64)
        counts = np.array([len(part) for part in self.parts], np.int64) // sizes[which]
        kind_of = np.repeat(which, counts)
        points, m = np.zeros((len(kind_of), 3)), np.full(len(kind_of), np.nan)
        for (order, has_z, has_m), i in known.items():
            joined = b"".join(part for part, kind in zip(self.parts, which.tolist(), strict=True) if kind == i)
            numbers = np.frombuffer(joined, f"{order}f8").reshape(-1, 2 + has_z + has_m)
            chosen = kind_of == i
            points[chosen, : 2 + has_z] = numbers[:, : 2 + has_z]
            if has_m:
                m[chosen] = numbers[:, -1]
        return points, counts, None if np.isnan(m).all() else m


def _count(data: bytes, at: int, order: str) -> tuple[int, int]:
    """Return a number of parts or points, and where it ends."""
    _within(data, at + 4)
    return int(struct.unpack_from(f"{order}I", data, at)[0]), at + 4


def _within(data: bytes, end: int) -> int:
    if end > len(data):
        raise ValueError("it is cut short")
    return end
