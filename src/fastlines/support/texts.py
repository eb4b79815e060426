"""Numbers, amounts of memory and names as short texts."""

from __future__ import annotations

from collections.abc import Iterable


def number_text(number: float) -> str:
    """Write a number in about four digits.

    Examples
    --------
    >>> number_text(12345.678), number_text(0.00012), number_text(-2.0)
    ('12,346', '0.00012', '-2')
    """
    return f"{number:,.0f}" if 1e4 <= abs(number) < 1e9 else f"{number:.4g}"


def range_text(low: float, high: float) -> str:
    """Write a range of numbers; one number if both ends are the same."""
    return number_text(low) if low == high else f"{number_text(low)} to {number_text(high)}"


def point_text(point: Iterable[float]) -> str:
    """Write the coordinates of a point.

    Examples
    --------
    >>> point_text([0, 0.1 + 0.2, -1e-9])
    '(0, 0.3, -1e-09)'
    """
    return f"({', '.join(map(number_text, point))})"


def bytes_text(number: int) -> str:
    """Write an amount of memory, such as 48 bytes, 5.8 kB or 1,234.5 MB."""
    if number < 1000:
        return f"{number} bytes"
    return f"{number / 1e3:.1f} kB" if number < 999_950 else f"{number / 1e6:,.1f} MB"


def count_of(number: int, noun: str) -> str:
    """Write a number of things.

    Examples
    --------
    >>> count_of(1, "node"), count_of(1200, "node")
    ('1 node', '1,200 nodes')
    """
    return f"{number:,} {noun}{'s' * (number != 1)}"


def listed(texts: Iterable[str], between: str = ", ", most: int = 8) -> str:
    """Join the first few texts, and say how many more there are.

    Examples
    --------
    >>> listed("abcdefghij")
    'a, b, c, d, e, f, g, h and 2 more'
    """
    given = list(texts)
    more = f" and {len(given) - most:,} more" if len(given) > most else ""
    return between.join(given[:most]) + more


def shortened(text: str, most: int = 40) -> str:
    """Return a text that is not too long.

    Examples
    --------
    >>> shortened("abcdefghij", 5)
    'abcd…'
    """
    return text if len(text) <= most else text[: most - 1] + "…"
