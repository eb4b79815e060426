"""Writes a case as a test that fails by itself: a file for pytest, which needs fastlines and NumPy alone."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import numpy as np

from . import balls
from .answers import OF_SURFACES, PAIR_COLUMNS, POINT_QUERIES, RAY_QUERIES, left_out
from .builds import text_of
from .case import FORESTS, Case, Question
from .parts import Part
from .scenes import Array

#: The columns of answers that a test compares.
COLUMNS = ("offsets", "t", "prim", "u", "distance", "t_out", "i", "j", "s", "sum", "squares", "count")
#: Numbers whose decimal text is at most this long are written so; others as hexadecimal, which is exact too.
SHORT = 8
#: Arrays whose text is longer have a line for each row.
LONG = 80


def number_text(x: float) -> str:
    """Return Python for a number, to the bit.

    Examples
    --------
    >>> number_text(0.5), number_text(float("inf")), number_text(0.1)
    ('0.5', 'inf', '0.1')
    >>> number_text(float(np.float32(0.1)))
    'x("0x1.99999a0000000p-4")'
    """
    text = repr(float(x))
    return text if len(text) <= SHORT else f'x("{float(x).hex()}")'


def array_text(values: Array) -> str:
    """Return Python for an array."""

    def nested(part: Any) -> str:
        if isinstance(part, list):
            return f"[{', '.join(map(nested, part))}]"
        return number_text(part) if isinstance(part, float) else repr(part)

    if values.size == 0:
        return f"np.zeros({values.shape}, np.{values.dtype})"
    text = nested(values.tolist())
    if len(text) > LONG and values.ndim > 1:  # a line for each row
        text = "".join(["[", *(f"\n        {nested(row)}," for row in values.tolist()), "\n    ]"])
    return f"np.array({text}, np.{values.dtype})"


def value_text(value: Any) -> str:
    """Return Python for an option."""
    if isinstance(value, np.ndarray):
        return array_text(value)
    return number_text(value) if isinstance(value, float) else text_of(value)


def text_of_test(case: Case, name: str, found_by: str, why: str) -> str:
    """Return the text of a test of a case with one question."""
    question = case.questions[0] if case.questions else None
    body = [
        *_geometry(case),
        *_environment(question),
        *_tree(case),
        *(_asked(case, question) if question is not None else ()),
    ]
    text = "\n".join(f"    {line}" if line else "" for line in body)
    head = [f'"""{_head(found_by, why)}"""', "", *_imports(text)]
    if any(part.kind == "own class" for part in case.parts):
        head += ["", "", inspect.getsource(balls.Balls).rstrip().replace("Any", "object")]
    arguments = [name for name in ("tmp_path", "monkeypatch") if f"{name}." in text or f"{name} /" in text]
    return "\n".join([*head, "", "", f"def {name}({', '.join(arguments)}):", text, ""])


def write_test(folder: Path, case: Case, name: str, found_by: str, why: str) -> Path:
    """Write the test of a case into a folder, and return its path."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.py"
    path.write_text(text_of_test(case, name, found_by, why), encoding="utf-8")
    return path


def _head(found_by: str, why: str) -> str:
    return f"Found by `{found_by}`.\n\n{why.replace(chr(92), '')}.\n"


def _imports(text: str) -> list[str]:
    """Return the imports, and the short names of numbers, that a body needs."""
    lines = ["import pickle", ""] if "pickle." in text else []
    lines += ["import numpy as np", "", "import fastlines as fl"]
    if "write_forest" in text:
        lines += ["from fastlines.forest.writing import write_forest"]
    names = [("inf", "np.inf", "inf"), ("nan", "np.nan", "nan"), ("x", "float.fromhex", 'x("')]
    used = [f"{name} = {value}" for name, value, sign in names if sign in text]
    return [*lines, "", *used] if used else lines


def _part_text(part: Part, offset: tuple[float, ...] | None, ends: str, spoiled: tuple[int, ...] = ()) -> str:
    """Return Python that makes a container; spoiled rows are given, and skipped."""
    rows = part.rows

    def given(name: str) -> str:
        text = array_text(rows[name])
        nothing = "np.nan" if rows[name].dtype.kind == "f" else "0"
        return f"np.insert({text}, {list(spoiled)}, {nothing}, axis=0)" if spoiled else text

    def placed(name: str) -> str:
        return given(name) if offset is None else f"{given(name)}.astype(np.float64) + offset"

    how = ("" if offset is None else ", offset=offset") + (', invalid="skip"' if spoiled else "")
    more = "".join(f", {name}={given(name)}" for name in ("radius", "strands") if name in rows)
    match part.kind:
        case "lines" | "cones":
            return f"fl.Lines.from_segments({placed(ends)}{more}{how})"
        case "spheres":
            return f"fl.Spheres.from_centres({placed('centres')}{more}{how})"
        case "curves":
            tolerance = number_text(part.options["tolerance"])
            return f"fl.Curves.from_bezier({placed('control')}{more}, tolerance={tolerance}{how})"
        case "own class":
            return f"Balls({array_text(rows['centres'])}, {array_text(rows['radius'])})"
        case kind:
            return f"fl.{kind.title()}({array_text(rows['corners'])})"


def _geometry(case: Case) -> list[str]:
    lines = [] if case.offset is None else [f"offset = np.array({list(case.offset)})"]
    lines.append(f"geometry = {_container(case)}")
    if case.spoiled:
        lines.append(f"given = {_container(case, case.spoiled)}")
    if case.frame is not None:
        lines.append(f"whole = {_container(case.whole)}  # its box is the frame")
    return lines


def _container(case: Case, spoiled: tuple[int, ...] = ()) -> str:
    texts = [_part_text(part, case.offset, "ends", spoiled) for part in case.parts]
    return texts[0] if len(texts) == 1 else f"fl.Geometry([{', '.join(texts)}])"


def _environment(question: Question | None) -> list[str]:
    lines = []
    if question is not None and question.simd is not None:
        lines.append(f'monkeypatch.setenv("FASTLINES_SIMD", "{question.simd}")')
    if question is not None and question.n_threads > 1:
        lines.append(f'monkeypatch.setenv("FASTLINES_NUM_THREADS", "{question.n_threads}")')
    return lines


def _tree(case: Case) -> list[str]:
    given, name = dict(case.build), "given" if case.spoiled else "geometry"
    if set(case.steps) & set(FORESTS):
        return _forest(case, given, name)
    settings = "".join(f", {name}={text_of(value)}" for name, value in given.items())
    if case.frame is not None:
        settings += f", frame={array_text(case.frame)}"
    lines = [f"tree = fl.build({name}{settings})"]
    for step in case.steps:
        match step:
            case "layout":
                lines.append("_ = tree.layout")
            case "pickle":
                lines.append("tree = pickle.loads(pickle.dumps(tree))")
            case "save" | "save with layout":
                layout = "" if step == "save" else ", layout=True"
                lines += [
                    f'tree.save(tmp_path / "tree.flt"{layout})',
                    'tree = fl.load(tmp_path / "tree.flt")',
                ]
            case "refit":
                lines.append(f"geometry = {_part_text(case.parts[0], case.offset, 'moved')}")
                lines.append("tree = tree.refit(geometry.segments.astype(np.float64) + np.array(geometry.offset))")
            case "without offset":
                lines.append("tree = tree.without_offset()")
            case "forest of one file":
                lines.append('tree.save(tmp_path / "tree.flt", layout=True)')
                lines.append('tree = fl.Forest(tmp_path / "tree.flt")')
    return lines


def _forest(case: Case, given: dict[str, Any], name: str) -> list[str]:
    n_tiles = f"max(1, min({case.n_tiles}, len({name})))"
    method = given.pop("method", None) if case.steps == ("forest",) else None
    settings = "".join(f", {name}={text_of(value)}" for name, value in given.items())
    if case.steps == ("forest",):
        tiles = f"np.arange(len({name})) * 7 % {n_tiles}"
        return [f'tree = write_forest({name}, tmp_path / "forest", {tiles}, {method!r}{settings})']
    settings += "" if case.offset is None or not case.n_prims else ", offset=offset"
    on = ".on(map)" if case.steps == ("mapped forest",) else ""
    most = f"max_segments=-(-len({name}) // {n_tiles}) or 1"
    return [f'tree = fl.build_forest([{name}], tmp_path / "forest", {most}{settings}){on}']


def _asked(case: Case, question: Question) -> list[str]:
    """Return the lines that ask both sides, and compare the answers."""
    query, options = question.query, dict(question.options)
    lines = ["asked = {"]
    for name, values in {**question.rows, **options}.items():
        if name == "channels":
            lines.append(f'    "values": {_values("geometry", values)},')
            continue
        moves = case.offset is not None and name in ("origins", "points", "low", "high")
        lines.append(f'    "{name}": {value_text(values)}{".astype(np.float64) + offset" if moves else ""},')
    lines.append("}")
    less = "asked"
    if "without offset" in case.steps and question.rows:
        moved = next(name for name in ("origins", "points", "low") if name in question.rows)
        less = f'asked | {{"{moved}": asked["{moved}"] - offset}}'
        if moved == "low":
            less = 'asked | {name: asked[name] - offset for name in ("low", "high")}'
    if question.other is not None:
        lines.append(f"second = {_part_text(question.other, case.offset, 'ends')}")
        lines.append("other = fl.build(second)" + (".without_offset()" if "without offset" in case.steps else ""))
    kernel = f', kernel="{question.kernel}"' if query in RAY_QUERIES and question.kernel != "auto" else ""
    compared = _compared(query, less, kernel, question.other is not None)
    if case.frame is not None:
        ignored = left_out({**question.rows, **options}, case.n_prims, case.whole.n_prims)
        more = f', "values": {_values("whole", options["channels"])}' if "channels" in options else ""
        beside = f'(whole, **asked | {{"ignore": {array_text(ignored)}{more}}}'
        compared = [line.replace("(geometry, **asked", beside) for line in compared]
    return lines + compared


def _values(name: str, n_channels: int) -> str:
    return f"(np.arange(len({name}) * {n_channels}) * 7 % 11 / 8 + 0.25).reshape(-1, {n_channels})"


def _compared(query: str, less: str, kernel: str, has_other: bool) -> list[str]:
    found = f"found = tree.{query}(**({less}){kernel})" if less != "asked" else f"found = tree.{query}(**asked{kernel})"
    names = ", ".join(f'"{name}"' for name in (OF_SURFACES if query == "first_surface" else COLUMNS))
    every = [
        f"for name in ({names}):",
        "    a, b = getattr(found, name, None), getattr(expected, name, None)",
        "    assert (a is None) == (b is None), name",
        "    assert a is None or np.asarray(a).tobytes() == np.asarray(b).tobytes(), (name, a, b)",
    ]
    other, second = (", other=other", ", other=second") if has_other else ("", "")
    expected = f"expected = fl.brute_force_pairs(geometry, **asked{second})"
    plain = ["assert np.array_equal(found, expected), (found, expected)"]
    match query:
        case "first_surface":
            return [found, 'expected = fl.brute_force(geometry, **asked, query="first_hit", at="surface")', *every]
        case "iter_all_hits":
            return [
                f"parts = list(tree.iter_all_hits(**({less}){kernel}))",
                'del asked["max_bytes"]',
                "expected = fl.brute_force(geometry, **asked)",
                *_joined(("t", "prim", "u", "distance")),
            ]
        case "along":
            moved = "" if less == "asked" else " - offset"
            return ['points = asked.pop("points")', f"found = tree.along(points{moved}, **asked)", *_NEAREST_OF_PAIRS]
        case "gather":
            return [found, "expected = fl.brute_force_gather(geometry, **asked)", *every]
        case "pairs":
            return [f"found = tree.pairs(**asked{other})", expected, *every]
        case "iter_pairs":
            asked = [f"parts = list(tree.iter_pairs(**asked{other}))", 'del asked["max_bytes"]']
            return [*asked, expected, *_joined(PAIR_COLUMNS)]
        case "in_box":
            return [found, "expected = fl.brute_force_in_box(geometry, **asked)", *every]
        case _:
            function = "brute_force_points" if query in POINT_QUERIES else "brute_force"
            compared = plain if query in ("any_hit", "count_hits", "count_within") else every
            return [found, f'expected = fl.{function}(geometry, **asked, query="{query}")', *compared]


def _joined(columns: tuple[str, ...]) -> list[str]:
    """Return the lines that compare the parts of an answer, one after the other."""
    names = ", ".join(f'"{name}"' for name in columns)
    return [
        f"for name in ({names}):",
        "    parts_of = [getattr(part, name) for part in parts]",
        "    a = np.concatenate([np.zeros(0, getattr(expected, name).dtype), *parts_of])",
        "    assert a.tobytes() == getattr(expected, name).tobytes(), name",
    ]


#: What is along a polyline is the nearest of all pairs with its segments.
_NEAREST_OF_PAIRS = (
    "needle = fl.Lines.from_segments(np.stack([points[:-1], points[1:]], axis=1), offset=geometry.offset)",
    'pairs = fl.brute_force_pairs(needle, asked.pop("radius"), geometry, **asked)',
    "order = np.lexsort((pairs.i, pairs.distance, pairs.j))",
    "best = order[np.diff(pairs.j[order], prepend=-1) > 0]",
    "assert found.u.tobytes() == pairs.t[best].tobytes()",
    "assert found.distance.tobytes() == pairs.distance[best].tobytes()",
    "assert found.segment.tobytes() == pairs.i[best].tobytes()",
)
