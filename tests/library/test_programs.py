"""Programs that are compiled against the installed library: by one command, and with CMake."""

from __future__ import annotations

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


@pytest.mark.parametrize("example", ["first_hit.cpp", "first_hit.c"])
def test_one_command_compiles_a_program(example: str, tmp_path: Path) -> None:
    compiler = needs("g++")
    flags = run(sys.executable, "-m", "fastlines", "--cflags", "--libs", cwd=tmp_path).split()
    source = EXAMPLES / example
    if source.suffix == ".c":
        include = f"-I{fl.get_include()}"
        run(
            needs("gcc"),
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-pedantic",
            include,
            "-c",
            str(source),
            cwd=tmp_path,
        )
        source = tmp_path / "first_hit.o"
    run(compiler, "-Wall", "-Wextra", "-Werror", str(source), *flags, "-o", "first_hit", cwd=tmp_path)
    assert run("./first_hit", cwd=tmp_path) == ANSWER


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


def test_the_commands_print_the_folders(tmp_path: Path) -> None:
    for option, folder in (
        ("--includedir", fl.get_include()),
        ("--libdir", fl.get_lib()),
        ("--cmakedir", fl.get_cmake_dir()),
    ):
        assert run(sys.executable, "-m", "fastlines", option, cwd=tmp_path).strip() == folder
