"""The formats of other distributions, which their entry points ``fastlines.formats`` name."""

from __future__ import annotations

from ..arrays import kind_of
from ..support.warn_caller import warn_caller
from .format import Format
from .source import reason

#: The group of entry points; the value of each is a `Format`.
GROUP = "fastlines.formats"


def find() -> list[tuple[str, Format]]:
    """Return the distribution and the format of each entry point; warn of what cannot be used, and leave it out."""
    from importlib.metadata import entry_points  # only for files: it takes as long to import as small ones to read

    found = []
    for point in entry_points(group=GROUP):
        owner = point.dist.name if point.dist else "a distribution without a name"
        try:
            row = point.load()
            if not isinstance(row, Format):
                raise TypeError(f"it is {kind_of(row)}; expected a fastlines.io.Format")
            if row.module is None:
                raise TypeError("it names no module; pass module=__name__")
        except Exception as error:  # that of anyone's module
            warn_caller(
                f"the format {point.name!r} of {owner} is left out, as its entry point {point.value!r} cannot be used "
                f"({type(error).__name__}: {reason(error)}); repair or uninstall {owner}"
            )
        else:
            found.append((owner, row))
    return found
