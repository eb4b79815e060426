"""Numbers, amounts of memory and names as short texts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping


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


def duration_text(seconds: float) -> str:
    """Write a time in whole seconds, minutes or hours, whichever has few digits.

    Examples
    --------
    >>> duration_text(0.6), duration_text(89), duration_text(200), duration_text(9000)
    ('1 second', '89 seconds', '3 minutes', '2.5 hours')
    """
    if seconds < 90:
        return counted(round(seconds), "seconds")
    return counted(round(seconds / 60), "minutes") if seconds < 5400 else f"{seconds / 3600:,.1f} hours"


#: Plurals that do not only end in s, and what is singular instead.
SINGULARS = {"leaves": "leaf", "vertices": "vertex", "indices": "index"}


def counted(number: int, nouns: str) -> str:
    """Write a number of things, whose noun is given in the plural.

    Examples
    --------
    >>> counted(1, "nodes"), counted(1200, "nodes"), counted(0, "boxes"), counted(1, "boxes"), counted(1, "leaves")
    ('1 node', '1,200 nodes', '0 boxes', '1 box', '1 leaf')
    """
    return f"{number:,} {singular(nouns) if number == 1 else nouns}"


def kinds_text(kinds: Mapping[str, int]) -> str:
    """Write how many things there are of each kind, by the names of the kinds as they are.

    Examples
    --------
    >>> kinds_text({"Point": 2, "Polygon": 1200})
    '2 Point, 1,200 Polygon'
    """
    return ", ".join(f"{number:,} {kind}" for kind, number in kinds.items())


def singular(nouns: str) -> str:
    """Return a noun in the singular.

    Examples
    --------
    >>> [singular(nouns) for nouns in ("rays", "boxes", "meshes", "bodies", "tori", "of your own")]
    ['ray', 'box', 'mesh', 'body', 'torus', 'of your own']
    """
    if nouns in SINGULARS:
        return SINGULARS[nouns]
    for plural, one in (("ies", "y"), ("xes", "x"), ("shes", "sh"), ("ches", "ch"), ("sses", "ss"), ("i", "us")):
        if nouns.endswith(plural):
            return nouns.removesuffix(plural) + one
    return nouns.removesuffix("s")


def with_article(name: str) -> str:
    """Return the name of a type with its article; a plural, such as that of a container, has none.

    Examples
    --------
    >>> with_article("list"), with_article("int"), with_article("Triangles"), with_article("Picture")
    ('a list', 'an int', 'Triangles', 'a Picture')
    """
    if name[:1].isupper() and name.endswith("s") and not name.endswith("ss"):
        return name
    return f"{'an' if name[:1].lower() in 'aeiou' else 'a'} {name}"


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


#: The most characters of what an error or a warning says of a file.
_MAX_MESSAGE = 700


def printable(text: str) -> str:
    """Replace characters that cannot be printed in one line by question marks."""
    return text if text.isprintable() else "".join(char if char.isprintable() else "?" for char in text)


def in_one_line(message: str) -> str:
    """Return a message that quotes a file as one printable line, without the middle of very long ones.

    Examples
    --------
    >>> len(in_one_line("x" * 5000))
    700
    """
    if len(message) > _MAX_MESSAGE:
        message = f"{message[: _MAX_MESSAGE // 2]} … {message[3 - _MAX_MESSAGE // 2 :]}"
    return printable(message)
