"""The arguments that all queries share: what Python, editors and type checkers see of them."""

from __future__ import annotations

import inspect
import math
import typing
from dataclasses import fields

import pytest

import fastlines as fl
from fastlines.query.queries import QUERIES
from fastlines.query.ray_arguments import RayArguments, RayOptions

SHARED = {
    "spread": 0.0,
    "ignore": None,
    "ignore_strands": None,
    "parts": None,
    "t_min": 0.0,
    "t_max": math.inf,
    "invalid": "error",
    "progress": False,
}
#: The other keywords of each query.
OWN = {
    "first_hit": {"at": "closest", "kernel": "auto"},
    "any_hit": {"at": "closest", "kernel": "auto"},
    "count_hits": {"at": "closest", "kernel": "auto"},
    "all_hits": {"at": "closest", "merge": None, "kernel": "auto"},
    "next_hits": {"rank": "t", "at": "closest", "kernel": "auto"},
    "brute_force": {"query": "all_hits", "at": "closest", "k": None, "rank": "t", "merge": None},
}
FUNCTIONS = {name: getattr(fl.Tree, name) for name in QUERIES} | {"brute_force": fl.brute_force}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_signatures_show_all_names_types_and_defaults(name):
    signature = inspect.signature(FUNCTIONS[name])
    found = {p.name: p.default for p in signature.parameters.values() if p.kind == p.KEYWORD_ONLY}
    assert found == SHARED | OWN[name]
    assert signature.parameters["t_min"].annotation == signature.parameters["origins"].annotation == "npt.ArrayLike"
    assert all(p.kind != p.VAR_KEYWORD for p in signature.parameters.values())
    named = [p.name for p in signature.parameters.values() if p.kind == p.POSITIONAL_OR_KEYWORD]
    assert named[1:4] == ["origins", "directions", "radius"]
    assert named[4:] == (["k"] if name == "next_hits" else [])


def test_type_checkers_see_the_same_options():
    options = typing.get_type_hints(RayOptions)
    arguments = typing.get_type_hints(RayArguments)
    assert [field.name for field in fields(RayArguments)] == ["origins", "directions", "radius", *options]
    assert {name: arguments[name] for name in options} == options


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_unknown_keyword_is_named(name):
    segments = [[[0, 0, 0], [1, 1, 1]]]
    ask = fl.brute_force if name == "brute_force" else getattr(fl.build(segments), name)
    given = {"origins": [0, 0, 0], "directions": [0, 0, 1], "radius": 0.1}
    given |= {"geometry": segments} if name == "brute_force" else {}
    given |= {"k": 1} if name == "next_hits" else {}
    for keyword in {"t_maxx", "kernel"} - set(OWN[name]):
        with pytest.raises(TypeError, match=rf"^{name}\(\) got an unexpected keyword argument '{keyword}'"):
            ask(**given, **{keyword: "auto"})
