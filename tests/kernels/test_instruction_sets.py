"""One source, several instruction sets: all give the same bits, under emulation too, and none uses code of another."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import pytest
from test_cpp import COMPILER, CPP, FLAGS, run

import fastlines as fl

CMAKE = (CPP / "simd_flags.cmake").read_text(encoding="utf-8")
COMMON = re.findall(r"-f[\w=-]+", CMAKE[CMAKE.index("set(simd_all ") :].split(")")[0])
OF_SET = {name: flags.split() for name, flags in re.findall(r"set\(simd_(\w+) (-[^)]*)\)", CMAKE)}

EMULATED = "neon, emulated"
CROSS_COMPILER, EMULATOR = "aarch64-linux-gnu-g++", "qemu-aarch64"
MISSING = [tool for tool in (CROSS_COMPILER, EMULATOR) if shutil.which(tool) is None]

PROGRAMS = ("answers", "culling", "hit_order", "deep_stacks")


def output(name: str, simd: str, folder: Path) -> str:
    """Compile a program for an instruction set and run it."""
    program = folder / f"{name}-{simd.replace(', ', '-')}"
    emulated = simd == EMULATED
    flags = ["-static"] if emulated else OF_SET.get(simd, [])
    compiler = CROSS_COMPILER if emulated else COMPILER
    # -O1: most of the time goes to the compiler. -w: GCC 12 warns of its own AVX-512 header.
    run(compiler, *FLAGS, *COMMON, *flags, "-O1", "-w", CPP / "tests" / f"{name}.cpp", "-o", program)
    return run(*[EMULATOR] * emulated, program)


@pytest.fixture(scope="module")
def outputs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[tuple[str, str], Future[str]]]:
    """All compilers run at once."""
    folder = tmp_path_factory.mktemp("programs")
    sets = [*([] if MISSING else [EMULATED]), *fl.available_simd()]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        yield {(name, simd): pool.submit(output, name, simd, folder) for name in PROGRAMS for simd in sets}


needs_tools = pytest.mark.skipif(bool(MISSING), reason=f"not installed: {', '.join(MISSING)}")
of_each_set = pytest.mark.parametrize("simd", [*fl.available_simd(), pytest.param(EMULATED, marks=needs_tools)])


@of_each_set
def test_answers_are_the_same(simd: str, outputs: dict[tuple[str, str], Future[str]]) -> None:
    name, digest = outputs["answers", simd].result().split()
    assert name == simd.removesuffix(", emulated")
    assert ["portable", digest] == outputs["answers", "portable"].result().split()


@of_each_set
def test_nothing_within_reach_is_culled(simd: str, outputs: dict[tuple[str, str], Future[str]]) -> None:
    name, n_near, n_kept, n_lost = outputs["culling", simd].result().split()
    assert name == simd.removesuffix(", emulated")
    assert int(n_lost) == 0
    assert 200_000 < int(n_near) <= int(n_kept) < 2 * int(n_near)


@of_each_set
def test_hits_are_put_in_order(simd: str, outputs: dict[tuple[str, str], Future[str]]) -> None:
    name, n_hits, n_wrong = outputs["hit_order", simd].result().split()
    assert name == simd.removesuffix(", emulated")
    assert int(n_hits) > 1_000_000
    assert int(n_wrong) == 0


@of_each_set
def test_stacks_grow(simd: str, outputs: dict[tuple[str, str], Future[str]]) -> None:
    assert outputs["deep_stacks", simd].result().split() == [simd.removesuffix(", emulated"), "800", "0"]


@pytest.mark.skipif(not sys.platform.startswith("linux") or shutil.which("nm") is None, reason="no nm to ask")
def test_engines_export_nothing_else() -> None:
    """A function that two modules export could be called by one and be the other's."""
    modules = sorted(Path(fl.__file__).parent.glob("_engine_*.so"))
    assert len(modules) >= len(fl.available_simd())
    for module in modules:
        symbols = run("nm", "-D", "--defined-only", module).splitlines()
        assert [line.split()[-1] for line in symbols] == [f"PyInit_{module.name.split('.')[0]}"]
