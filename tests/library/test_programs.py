"""Programs that are compiled against the installed library: by one command, and with CMake."""

from __future__ import annotations

import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fastlines as fl

EXAMPLES = Path(__file__).parents[2] / "examples"
ANSWER = "BVH: segment 0 at t = 5\nKD tree: segment 0 at t = 5\n"


def run(*command: str, cwd: Path) -> str:
    """Run a command and return what it prints."""
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, f"{shlex.join(command)}\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.fixture(autouse=True)
def needs_library() -> None:
    try:
        fl.get_include()
    except fl.FastlinesError as error:
        pytest.skip(f"this is not an installation: {error}")


def needs(program: str) -> str:
    found = shutil.which(program)
    if found is None:
        pytest.skip(f"there is no {program} here")
    return found


WARNINGS = "-Wall", "-Wextra", "-Werror", "-pedantic"


def flags(*options: str, cwd: Path) -> list[str]:
    """Return what the command line prints for a compiler."""
    return run(sys.executable, "-m", "fastlines", *options, cwd=cwd).split()


@pytest.mark.parametrize("standard", ["c++20", "c++23"])
def test_one_command_compiles_a_program(standard: str, tmp_path: Path) -> None:
    compiler, source = needs("g++"), str(EXAMPLES / "first_hit.cpp")
    ours = flags("--cflags", "--libs", cwd=tmp_path)
    run(compiler, f"-std={standard}", *WARNINGS, source, *ours, "-o", "first_hit", cwd=tmp_path)
    assert run("./first_hit", cwd=tmp_path) == ANSWER


def test_one_command_compiles_a_program_in_c(tmp_path: Path) -> None:
    compiler, linker, source = needs("gcc"), needs("g++"), str(EXAMPLES / "first_hit.c")
    run(compiler, "-std=c99", *WARNINGS, *flags("--cflags", cwd=tmp_path), "-c", source, cwd=tmp_path)
    run(linker, "first_hit.o", *flags("--libs", cwd=tmp_path), "-o", "first_hit", cwd=tmp_path)
    assert run("./first_hit", cwd=tmp_path) == ANSWER


@pytest.mark.parametrize(("standard", "version"), [("c++20", 202002), ("c++23", 202100)])
def test_the_flags_keep_the_standard_that_is_given(standard: str, version: int, tmp_path: Path) -> None:
    (tmp_path / "version.cpp").write_text(
        f"#include <fastlines/fastlines.hpp>\nstatic_assert(__cplusplus >= {version}L);\nint main() {{ return 0; }}\n"
    )
    ours = flags("--cflags", cwd=tmp_path)
    run(needs("g++"), f"-std={standard}", "version.cpp", *ours, "-fsyntax-only", cwd=tmp_path)


def test_an_older_standard_is_refused_by_name(tmp_path: Path) -> None:
    command = [needs("g++"), "-std=c++17", "-fsyntax-only", "-xc++", "-", *flags("--cflags", cwd=tmp_path)]
    program = "#include <fastlines/fastlines.hpp>\n"
    found = subprocess.run(command, input=program, capture_output=True, text=True, timeout=60).stderr
    assert "fastlines needs C++20 or later: compile with -std=c++20 or -std=c++23" in found


@pytest.mark.parametrize("target", ["fastlines::fastlines", "fastlines::shared"])
def test_cmake_finds_the_package(target: str, tmp_path: Path) -> None:
    cmake = needs("cmake")
    needs("g++")
    shutil.copy(EXAMPLES / "first_hit.cpp", tmp_path)
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.18)\n"
        "project(program LANGUAGES CXX)\n"
        "find_package(fastlines REQUIRED)\n"
        "add_executable(first_hit first_hit.cpp)\n"
        f"target_link_libraries(first_hit PRIVATE {target})\n"
    )
    run(cmake, "-S", ".", "-B", "build", f"-Dfastlines_DIR={fl.get_cmake_dir()}", cwd=tmp_path)
    run(cmake, "--build", "build", cwd=tmp_path)
    assert run("build/first_hit", cwd=tmp_path) == ANSWER
    if target == "fastlines::shared" and sys.platform == "linux":
        name = interface_name()
        assert re.search(
            rf"^\s*{name} => \S+/{name} ", run(needs("ldd"), "build/first_hit", cwd=tmp_path), re.MULTILINE
        )


def interface_name() -> str:
    """Return the name by which programs ask for the shared library: until 1.0, a minor version may change it."""
    major, minor, _ = fl.__version__.split(".", 2)
    return f"libfastlines.so.{'0.' + minor if major == '0' else major}"


@pytest.mark.skipif(sys.platform != "linux", reason="shared libraries have other names here")
def test_a_program_asks_for_the_version_of_the_shared_library(tmp_path: Path) -> None:
    compiler, source, name = needs("g++"), str(EXAMPLES / "first_hit.cpp"), interface_name()
    lib = Path(fl.get_lib())
    assert (lib / name).is_file()
    ours = [*flags("--cflags", cwd=tmp_path), str(lib / name), f"-Wl,-rpath,{lib}"]
    run(compiler, "-std=c++20", source, *ours, "-o", "first_hit", cwd=tmp_path)
    assert run("./first_hit", cwd=tmp_path) == ANSWER
    assert f"{name} => {lib / name} " in run(needs("ldd"), "first_hit", cwd=tmp_path)


def test_the_commands_print_the_folders(tmp_path: Path) -> None:
    for option, folder in (
        ("--includedir", fl.get_include()),
        ("--libdir", fl.get_lib()),
        ("--cmakedir", fl.get_cmake_dir()),
    ):
        assert run(sys.executable, "-m", "fastlines", option, cwd=tmp_path).strip() == folder


@pytest.mark.parametrize("header", ["fastlines.h", "math/vec.hpp"])
def test_32_bits_are_refused(tmp_path: Path, header: str) -> None:
    """Of the core, all headers of geometry include the second; the standard library for 32 bits need not be there."""
    if platform.machine() != "x86_64":
        pytest.skip("this compiler has no -m32")
    for name in ("array", "limits"):
        (tmp_path / name).touch()
    command = [needs("g++"), "-m32", "-ffreestanding", "-nostdinc++", "-I.", "-fsyntax-only", "-x", "c++"]
    done = subprocess.run(
        [*command, "-include", str(Path(fl.get_include()) / "fastlines" / header), os.devnull],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode != 0
    assert "fastlines needs a 64-bit processor" in done.stderr
