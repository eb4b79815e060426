"""Units of length: how many metres they are."""

from __future__ import annotations

import math
import re

#: Metres in each unit that has a name.
METERS = {
    "km": 1000.0, "m": 1.0, "cm": 0.01, "mm": 0.001, "µm": 1e-6, "nm": 1e-9, "Å": 1e-10, "in": 0.0254, "ft": 0.3048,
}  # fmt: skip


def unit_of(meters: float) -> str:
    """Return the name of the unit that has a length in metres.

    Examples
    --------
    >>> unit_of(0.001), unit_of(0.3)
    ('mm', '0.3 m')
    """
    for name, size in METERS.items():
        if math.isclose(meters, size, rel_tol=1e-6):
            return name
    return f"{float(meters)!r} m"


def meters_of(unit: str) -> float | None:
    """Return how many metres a unit is; None if it is not a known length, such as a degree.

    Examples
    --------
    >>> meters_of("mm"), meters_of("0.3 m"), meters_of("degree")
    (0.001, 0.3, None)
    """
    number = re.fullmatch(r"([0-9.]+(?:e[+-]?[0-9]+)?) m", unit)
    try:
        meters = float(number[1]) if number else 0.0
    except ValueError:
        meters = 0.0
    meters = meters if math.isfinite(meters) else 0.0
    # The micro sign has two code points.
    return METERS.get(unit.replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}")) or meters or None


def factor_between(unit: str, other: str) -> float | None:
    """Return the factor that takes lengths in one unit to another one; None if one of them is not a known length.

    Examples
    --------
    >>> print(f"{factor_between('Å', 'µm'):g}", factor_between("degree", "mm"))
    0.0001 None
    """
    sizes = meters_of(unit), meters_of(other)
    return sizes[0] / sizes[1] if sizes[0] and sizes[1] else None
