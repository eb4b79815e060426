"""How much to measure."""

from __future__ import annotations

from dataclasses import dataclass

from ..harness.preset import TimedPreset, sized
from ..peers import tuning


@dataclass(frozen=True, kw_only=True)
class EnginePreset(TimedPreset):
    """How much to measure.

    Parameters
    ----------
    kinds : tuple of str
        Kinds of rays: keys of `rays.KINDS`.
    method : str
        The builder of our tree.
    effort : float, optional
        The effort of "best", as in `fastlines.build`: from 0, the fastest build, to 1, the best tree.
    peer : bool
        Measure Embree too.
    trial : int
        The number of rays of a trial of all the peer's configurations, after which only the fastest are timed.
    near : float
        A configuration is timed only if its trial takes at most `near` times as long as the fastest.
    n_timed : int
        The maximum number of timed configurations. The fastest user geometry is always timed, even if it is one more.
    lengths : tuple of float
        The piece lengths that tuning tries for Embree, as fractions of the box's diagonal.
    retune : bool
        Ignore the lengths that an earlier run found.
    one_by_one : bool
        Trace each ray by a call of its own: of our C++ library (shapes: with our kernel "single"), and of Embree's
        rtcIntersect1.
    built_for : float, optional
        Use only user geometry for Embree, built for this radius and queried with radii no larger.
    shapes : tuple of str
        Measure these keys of `shapes.SHAPES` instead of lines with the radius of the query.
    """

    n_rays: int = sized(1 << 20, 1 << 17)
    rounds: int = 3
    seconds: float = sized(0.4, 0.25)
    kinds: tuple[str, ...] = ("camera", "random", "ao")
    method: str = "best"
    effort: float | None = None
    peer: bool = True
    trial: int = sized(1 << 14, 1 << 12)
    n_timed: int = sized(3, 2)
    near: float = 1.25
    lengths: tuple[float, ...] = sized(tuning.LENGTHS, (0.0, 1 / 16, 1 / 64))
    retune: bool = False
    one_by_one: bool = False
    built_for: float | None = None
    shapes: tuple[str, ...] = ()
