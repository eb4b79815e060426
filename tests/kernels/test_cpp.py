"""The C++ core without Python: headers that stand alone, the example, and primitives that the library does not know."""

from __future__ import annotations

import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from support.patience import HANGS

CPP = Path(__file__).parents[2] / "cpp"
FLAGS = ["-std=c++20", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", "-pthread", "-I", str(CPP)]
COMPILER = os.environ.get("CXX") or shutil.which("g++") or shutil.which("clang++") or "c++"


def run(*command: str | Path) -> str:
    result = subprocess.run(command, capture_output=True, text=True, timeout=HANGS, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def test_every_header_stands_alone(tmp_path: Path) -> None:
    # The wrappers of one instruction set are for its own flags.
    headers = sorted(set((CPP / "fastlines").rglob("*.hpp")) - set((CPP / "fastlines" / "simd").glob("avx*.hpp")))
    assert len(headers) > 20

    def check(header: Path) -> None:
        source = tmp_path / f"{header.parent.name}-{header.stem}.cpp"
        source.write_text(f'#include "{header.relative_to(CPP)}"\n')
        run(COMPILER, *FLAGS, "-fsyntax-only", source)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(check, headers))


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("examples/first_hit.cpp", "BVH: segment 0 at t = 5\nKD tree: segment 0 at t = 5\n"),
        ("tests/custom_primitive.cpp", "valid\n"),
        ("tests/memory.cpp", " 0 missed\n"),
    ],
)
def test_program(source: str, said: str, tmp_path: Path) -> None:
    program = tmp_path / "program"
    run(COMPILER, *FLAGS, "-O1", CPP / source, "-o", program)
    assert said in run(program)
