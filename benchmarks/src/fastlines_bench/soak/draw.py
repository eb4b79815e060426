"""Draws a case from its seed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fastlines import InputError

from .answers import PAIR_QUERIES, POINT_QUERIES, QUERIES, RAY_QUERIES
from .builds import random_build
from .case import FORESTS, Case
from .parts import AXES, LINES, MAKERS, PARTS, random_part
from .questions import Scene, queries_for, random_question
from .scenes import SHAPES, Array, Random
from .trees import geometry_of, moved

#: The number of primitives, and how often.
COUNTS, SHARES = (0, 1, 3, 12, 40, 120, 1000), (0.02, 0.06, 0.12, 0.3, 0.35, 0.12, 0.03)
#: How many questions a case has.
N_QUESTIONS = 8
#: The kinds of geometry, for `--only`.
KINDS = (*MAKERS, "several parts")


@dataclass(frozen=True)
class Choice:
    """What cases are drawn from: kinds of geometry, and queries."""

    kinds: tuple[str, ...] = KINDS
    queries: tuple[str, ...] = QUERIES

    @staticmethod
    def of(names: tuple[str, ...] | None) -> Choice:
        """Return the choice that names make; none of one sort are all of it."""
        chosen = names or ()
        kinds = tuple(name for name in KINDS if name in chosen)
        queries = tuple(name for name in QUERIES if name in chosen)
        if queries and not set(queries) - {*PAIR_QUERIES, "along"}:
            able = tuple(name for name in kinds or KINDS if name in (*AXES, "several parts"))
            if not able:
                raise InputError(f"--only: {', '.join(kinds)} have no {', '.join(queries)}; name lines, spheres, …")
            kinds = able
        return Choice(kinds or KINDS, queries or QUERIES)


def draw_case(seed: int, number: int, choice: Choice | None = None) -> Case:
    """Return case `number` of a soak with this seed; its questions are drawn for its geometry."""
    choice = choice or Choice()
    rng = np.random.default_rng([seed, number])
    kind = str(rng.choice(choice.kinds))
    n = int(rng.choice(COUNTS, p=SHARES))
    shape = str(rng.choice(list(SHAPES)))
    kinds = [kind]
    if kind == "several parts":
        n, kinds = min(n, 120), [str(one) for one in rng.choice(PARTS, int(rng.integers(2, 5)))]
    elif kind in ("curves", "own class"):
        n = min(n, 40)
    parts = tuple(random_part(rng, one, max(n // len(kinds), int(n > 0)), shape)[1] for one in kinds)
    case = Case(parts, {}, scene=shape)
    if all(part.kind in AXES for part in parts) and rng.random() < 0.2:
        case = replace(case, offset=(5.3e6, -4.1e5, 200.0))
    case = replace(case, steps=_steps(rng, case), n_tiles=int(rng.choice([1, 2, 5])))
    geometry = geometry_of(case)
    scene = _scene(case, geometry)
    is_forest, is_one = bool(set(case.steps) & {*FORESTS, "forest of one file"}), len(parts) == 1
    if is_one and parts[0].kind in AXES and not case.is_refit and rng.random() < 0.12:
        case = replace(
            case, spoiled=tuple(np.sort(rng.integers(0, case.n_prims + 1, int(rng.integers(1, 4)))).tolist())
        )
    # With an offset, the corners that brute force is given would be rounded again.
    if case.n_prims and case.offset is None and not case.is_refit and not is_forest and rng.random() < 0.15:
        case = replace(case, frame=_frame(rng, geometry))
    is_plain = all(part.kind == "lines" for part in parts) and not is_forest
    case = replace(case, build=random_build(rng, is_plain, len(geometry.build_data()[1])))
    queries = [name for name in queries_for(scene) if name in choice.queries]
    if case.frame is not None:
        queries = [name for name in queries if name in (*RAY_QUERIES, *POINT_QUERIES)]
    asked = [str(name) for name in rng.choice(queries, N_QUESTIONS)] if queries else []
    return replace(case, questions=tuple(random_question(rng, scene, name) for name in asked))


def _scene(case: Case, geometry: Any) -> Scene:
    """Return what questions need to know."""
    parts = [moved(part) for part in case.parts] if case.is_refit else list(case.parts)
    kinds = {part.kind for part in parts}
    if case.is_refit:
        geometry = geometry_of(replace(case, parts=tuple(parts)))
    ends = np.concatenate([_ends(part.corners()) for part in parts])
    return Scene(geometry, ends, case.n_prims, not kinds - {*AXES}, not kinds - {"lines", "cones", "curves"})


def _frame(rng: Random, geometry: Any) -> Array:
    """Return a box around all primitives: of the same size, or larger on some sides."""
    low, high = np.asarray(geometry.bounds, np.float64)
    size = float((high - low).max()) or 1.0
    more = size * 10 ** rng.uniform(-3, 1.5, (2, 3)) * rng.choice([0, 1], (2, 3))
    box = np.stack([low - more[0], high + more[1]]).astype(np.float32)
    return np.stack([np.minimum(box[0], geometry.bounds[0]), np.maximum(box[1], geometry.bounds[1])])


def _ends(corners: Array) -> Array:
    """Return a line through each primitive, from its first to its last corner."""
    points = corners.astype(np.float64)
    return points[:, [0, -1]] if points.ndim == 3 else np.stack([points, points], axis=1)


def _steps(rng: Random, case: Case) -> tuple[str, ...]:
    """Return what is done with the tree."""
    are_lines = len(case.parts) == 1 and case.parts[0].kind in LINES
    is_own = case.parts[0].kind == "own class"
    if are_lines and rng.random() < 0.2:
        return (str(rng.choice(FORESTS)),)
    if rng.random() < 0.3:
        return ()
    possible = ["layout", "pickle"]
    possible += [] if is_own else ["save", "save with layout"]
    possible += ["refit"] if are_lines else []
    chosen = [name for name in rng.permutation(possible) if rng.random() < 0.4]
    if case.offset is not None and rng.random() < 0.5:
        chosen.append("without offset")
    elif not is_own and rng.random() < 0.1:
        chosen.append("forest of one file")
    return tuple(map(str, chosen))
