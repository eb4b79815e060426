"""One cell: a trial of all configurations of the peer, then turns of ours and of its fastest on the same rays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..harness.compare import Difference, compare
from ..harness.rays import RayBatch
from ..harness.turns import MAX_HITS, count_hits
from ..peers import embree
from .preset import EnginePreset
from .result import Side

#: The name of the side of ours that is compared with the peer.
OURS = "ours"

#: A trial that is shorter than this, in seconds, is repeated once.
SHORT_TRIAL = 0.1

#: Answers a batch of rays.
Answer: TypeAlias = Callable[[RayBatch], Any]


class Found(NamedTuple):
    """The numbers of rays and of hits, our millions of rays per second, the peer's sides, and our other rates."""

    n_rays: int
    n_hits: int
    mrays: float
    sides: list[Side]
    others: dict[str, float]


@dataclass(frozen=True)
class Contest:
    """The settings of all cells, and the clock."""

    preset: EnginePreset
    now: Callable[[], float]

    def run(
        self,
        rays: RayBatch,
        query: str,
        own: Mapping[str, Answer],
        scenes: embree.Scenes | None,
        builds: Iterable[embree.Build],
        compare: Callable[[str, Any, Any], Difference] = compare,
    ) -> Found:
        """Measure a cell.

        Parameters
        ----------
        rays : RayBatch
        query : str
            "first", "any" or "all".
        own : mapping of str to callable
            Ours, by name. `OURS` is compared with the peer; the others only take turns.
        scenes : Scenes or None
            The peer's scenes; None without a peer.
        builds : iterable of Build
            The peer's builds.
        compare : callable
            Returns the differences between our answer to the query and the peer's.
        """
        preset, ours = self.preset, own[OURS]

        # Time a trial of all configurations.
        few = rays.part(preset.trial)
        trials = {name: self._time(answer_to, few) for name, answer_to in own.items()}
        our_answer = trials[OURS][1]
        slowest = max(seconds for seconds, _ in trials.values())
        tried: dict[embree.Config, tuple[float, Difference]] = {}
        if scenes is not None:
            for config in embree.configs(scenes, builds, query, few, preset.one_by_one):
                scenes.get(config.build)  # built before the clock runs
                seconds, answer = self._time(partial(scenes.query, config, query), few)
                if seconds < SHORT_TRIAL:
                    seconds = min(seconds, self._time(partial(scenes.query, config, query), few)[0])
                tried[config] = seconds, compare(query, our_answer, answer)
        fastest = sorted(tried, key=lambda config: tried[config][0])
        near = [config for config in fastest if tried[config][0] <= preset.near * tried[fastest[0]][0]][
            : preset.n_timed
        ]
        exact = next((config for config in fastest if config.build.geometry == "user"), None)
        near = list(dict.fromkeys([*near, *([exact] if exact else [])]))

        # Alternate all sides on as many rays as there is time for.
        slowest = max([slowest, *(tried[config][0] for config in near)])
        n_rays = max(len(few), int(len(few) * preset.seconds / max(slowest, 1e-6)))
        many = rays.part(n_rays)
        parts = many.slices(int(MAX_HITS / max(1.0, len(our_answer) / len(few)))) if query == "all" else [many]
        everyone: list[str | embree.Config] = [*own, *near]
        n_hits, times = 0, dict.fromkeys(everyone, np.inf)
        differences = dict.fromkeys(near, Difference())
        for i_round in range(preset.rounds):
            turns = dict.fromkeys(everyone, 0.0)
            for part in parts:
                seconds, our_answer = self._time(ours, part)
                turns[OURS] += seconds
                if i_round == 0:
                    n_hits += count_hits(query, our_answer)
                for name, answer_to in own.items():
                    turns[name] += self._time(answer_to, part)[0] if name != OURS else 0.0
                for config in near:
                    assert scenes is not None
                    seconds, answer = self._time(partial(scenes.query, config, query), part)
                    turns[config] += seconds
                    if i_round == 0:
                        differences[config] += compare(query, our_answer, answer)
            times = {side: min(times[side], turns[side]) for side in times}

        sides = []
        for config in fastest:
            assert scenes is not None
            timed = config in times
            n, seconds = (len(many), times[config]) if timed else (len(few), tried[config][0])
            sides.append(
                Side(
                    config,
                    n / max(seconds, 1e-9) / 1e6,
                    n,
                    preset.rounds if timed else 0,
                    scenes.build_seconds(config.build),
                    scenes.get(config.build).bytes,
                    differences[config] if timed else tried[config][1],
                )
            )
        rates = {name: len(many) / max(times[name], 1e-9) / 1e6 for name in own}
        return Found(len(many), n_hits, rates.pop(OURS), sides, rates)

    def _time(self, answer_to: Answer, rays: RayBatch) -> tuple[float, Any]:
        start = self.now()
        answer = answer_to(rays)
        return self.now() - start, answer
