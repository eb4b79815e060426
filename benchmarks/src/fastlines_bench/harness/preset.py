"""Presets: how much a benchmark measures. Every command has a full and a quick preset, which options can change."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Self


def sized(full: Any, quick: Any) -> Any:
    """Return a field of a preset, given its values in the full and in the quick preset."""
    metadata = {"quick": quick}
    if isinstance(full, dict):
        return field(default_factory=full.copy, metadata=metadata)
    return field(default=full, metadata=metadata)


@dataclass(frozen=True, kw_only=True)
class Preset:
    """The base of all presets."""

    @classmethod
    def of(cls, quick: bool = False, **given: Any) -> Self:
        """Return the full or the quick preset, with the given values that are not None."""
        values = {each.name: each.metadata["quick"] for each in fields(cls) if quick and "quick" in each.metadata}
        return cls(**values | {name: value for name, value in given.items() if value is not None})


@dataclass(frozen=True, kw_only=True)
class TimedPreset(Preset):
    """The base of all presets for timed queries.

    Parameters
    ----------
    n_threads : int
        The number of threads of all sides, in builds and in queries.
    n_rays : int
        The maximum number of rays for one figure, up to rounding to whole blocks.
    rounds : int
        The number of rounds, in each of which all sides run once. The best time of a query and the median time of a
        build count, unless a command says otherwise.
    seconds : float
        The approximate time of the slowest side in one round; fewer rays are traced if all would take longer.
    """

    n_threads: int = 1
    n_rays: int = 1 << 18
    rounds: int = 5
    seconds: float = 0.4
