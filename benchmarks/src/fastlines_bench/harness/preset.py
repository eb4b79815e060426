"""How much a benchmark measures: every command has a full preset and a quick one, and options that change either."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Self


def sized(full: Any, quick: Any) -> Any:
    """Declare a field of a preset by its values in the full and in the quick one."""
    metadata = {"quick": quick}
    if isinstance(full, dict):
        return field(default_factory=full.copy, metadata=metadata)
    return field(default=full, metadata=metadata)


@dataclass(frozen=True, kw_only=True)
class Preset:
    """The base of all presets."""

    @classmethod
    def of(cls, quick: bool = False, **given: Any) -> Self:
        """Make the full or the quick preset, and change what is given and not None."""
        values = {each.name: each.metadata["quick"] for each in fields(cls) if quick and "quick" in each.metadata}
        return cls(**values | {name: value for name, value in given.items() if value is not None})


@dataclass(frozen=True, kw_only=True)
class TimedPreset(Preset):
    """What all presets for timed queries have.

    Parameters
    ----------
    n_threads : int
        Of all sides, in builds and in queries.
    n_rays : int
        At most so many rays, or a few more, for one figure.
    rounds : int
        All sides take turns so often. Of queries the best time counts, of builds the median.
    seconds : float
        About how long one turn of the slowest side takes; fewer rays are traced if all would take longer.
    """

    n_threads: int = 1
    n_rays: int = 1 << 18
    rounds: int = 5
    seconds: float = 0.4
