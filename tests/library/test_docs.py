"""The manual of the library: its code compiles, and it describes all that the headers declare."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import fastlines as fl

DOCS = Path(__file__).parents[2] / "docs"
BLOCKS = re.findall(r"^```(cpp|c)\n(.*?)^```$", (DOCS / "cpp.md").read_text("utf-8"), re.DOTALL | re.MULTILINE)
COMMANDS = {"cpp": ("g++", "-xc++", "-std=c++20"), "c": ("gcc", "-xc", "-std=c99", "-pedantic")}
#: What fragments use but do not declare, by language.
CONTEXT = {
    "cpp": """
        #include <cstdio>
        #include <fastlines/fastlines.hpp>
        void use(float t, int id);
        void gather(std::size_t ray, const fl::Hits& hits);
        void fragment(const fl::Tree& tree, const fl::Ray& ray, float radius, std::span<const fl::Vec3> origins,
                      std::span<const fl::Vec3> directions, std::span<const fl::Vec3d> points, const fl::Tree& other,
                      const float* lines, int n, float d)
    """,
    "c": """
        #include <fastlines/fastlines.h>
        #include <stdio.h>
        void use(int64_t prim);
        void fragment(const float* segments, size_t n, fl_ray ray)
    """,
}


def program(language: str, code: str) -> str:
    """Return a whole program: the code itself, or the code as a function after its includes."""
    if "int main(" in code:
        return code
    lines = code.splitlines()
    includes = [line for line in lines if line.startswith("#include")]
    rest = [line for line in lines if line not in includes]
    return "\n".join([*includes, CONTEXT[language], "{", *rest, "}\n"])


def errors(language: str, source: str) -> str:
    """Return what the compiler reports about a program."""
    compiler, *options = COMMANDS[language]
    if shutil.which(compiler) is None:
        pytest.skip(f"there is no {compiler} here")
    try:
        include = fl.get_include()
    except fl.FastlinesError as error:
        pytest.skip(f"this is not an installation: {error}")
    warnings = "-Wall", "-Werror", "-Wno-unused-variable", "-Wno-unused-but-set-variable"
    command = [compiler, *options, *warnings, "-fsyntax-only", f"-I{include}", "-"]
    return subprocess.run(command, input=source, capture_output=True, text=True, timeout=60).stderr


@pytest.mark.parametrize(("language", "code"), BLOCKS, ids=[code.splitlines()[0] for _, code in BLOCKS])
def test_code_compiles(language: str, code: str) -> None:
    assert errors(language, program(language, code)) == ""


def test_code_is_found_and_errors_are_too() -> None:
    assert {language for language, _ in BLOCKS} == COMMANDS.keys()
    assert "last_hit" in errors("cpp", program("cpp", "tree.last_hit(ray, radius);"))


@pytest.fixture(scope="module")
def headers() -> dict[str, list[Any]]:
    """Return the declarations of the headers, by language."""
    module = runpy.run_path(str(DOCS / "_ext/headers.py"), run_name="headers")
    return {
        language: [each for path in paths for each in module["read"](path)]
        for language, paths in module["HEADERS"].items()
    }


def with_members(declarations: list[Any]) -> Iterator[Any]:
    for each in declarations:
        yield each
        yield from with_members(each.members)


@pytest.mark.parametrize(("language", "page"), [("cpp", "cpp_api.md"), ("c", "c_api.md")])
def test_everything_is_described_once(headers: dict[str, list[Any]], language: str, page: str) -> None:
    described = " ".join(re.findall(r"^\.\. declared:: (.*)$", (DOCS / page).read_text("utf-8"), re.MULTILINE)).split()
    assert sorted(described) == sorted({each.name for each in headers[language] if each.name})


@pytest.mark.parametrize("language", ["cpp", "c"])
def test_everything_has_a_comment(headers: dict[str, list[Any]], language: str) -> None:
    assert [each.name for each in with_members(headers[language]) if each.name and not each.comment] == []


def test_exported_functions_are_found(headers: dict[str, list[Any]]) -> None:
    code = "".join((DOCS.parent / "cpp/fastlines" / name).read_text("utf-8") for name in ("fastlines.h", "gather.h"))
    exported = re.findall(r"^FASTLINES_API [^(]*?(\w+)\(", code, re.MULTILINE)
    assert [each.name for each in headers["c"] if each.kind == "function"] == exported
