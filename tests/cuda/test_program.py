"""The kernels compile by NVRTC, which needs no GPU, and their arithmetic rounds each operation once."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import fastlines as fl
from fastlines.cuda import program, scene

PRIMITIVES = list(scene.PRIMITIVES.values())
SHARED = "FASTLINES_SHARED_STACK"
#: Variants of the kernels with another stack, or another traversal.
VARIANTS: list[dict[str, int]] = [
    {},
    {SHARED: 16},
    {program.GROUP: 16},
    {program.GROUP: 16, SHARED: 16},
    {program.GROUP: 16, SHARED: 64},
]


def require_nvrtc() -> None:
    pytest.importorskip("cuda.core", reason="needs fastlines[cuda]")
    pytest.importorskip("cuda.bindings.nvrtc", reason="needs fastlines[cuda]")


def ptx(primitives: str, **others: bool) -> str:
    """Compile to PTX, which shows how each operation is rounded. (`Program.compile` would ask the driver first.)"""
    from cuda.bindings import nvrtc
    from cuda.core import ProgramOptions

    how = program.options("compute_90", primitives, 64) | others
    flags = ProgramOptions(**how).as_bytes("nvrtc")
    error, compiled = nvrtc.nvrtcCreateProgram(program.SOURCE.encode(), b"kernels.cu", 0, [], [])
    assert int(error) == 0
    (error,) = nvrtc.nvrtcCompileProgram(compiled, len(flags), flags)
    log = b" " * nvrtc.nvrtcGetProgramLogSize(compiled)[1]
    nvrtc.nvrtcGetProgramLog(compiled, log)
    assert int(error) == 0, log.decode()
    size = nvrtc.nvrtcGetPTXSize(compiled)[1]
    text = b" " * size
    nvrtc.nvrtcGetPTX(compiled, text)
    nvrtc.nvrtcDestroyProgram(compiled)
    return text.decode()


@pytest.mark.parametrize("primitives", PRIMITIVES)
def test_each_operation_is_rounded_once(primitives: str) -> None:
    require_nvrtc()
    text = ptx(primitives)
    operations = set(re.findall(r"\b(?:add|sub|mul|div|sqrt|fma|mad|rcp|rsqrt)[.\w]*\.f(?:32|64)\b", text))
    # Fused multiply-adds are those of culling, in float32.
    exact = {f"{name}.rn.{form}" for name in ("add", "sub", "mul", "div", "sqrt", "rcp") for form in ("f32", "f64")}
    assert operations - exact == {"fma.rn.f32"}
    assert {"div.rn.f32", "sqrt.rn.f32", "rcp.rn.f64", "sqrt.rn.f64"} <= operations
    assert ".ftz" not in text
    assert ".approx" not in text
    # The compiler would fuse more, if it might.
    fused = ptx(primitives, fma=True)
    assert "fma.rn.f64" in fused
    assert fused.count("fma.rn.f32") > text.count("fma.rn.f32")


@pytest.mark.parametrize("tuning", VARIANTS, ids=str)
def test_variants_compile(tuning: dict[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    require_nvrtc()
    for name, value in tuning.items():
        monkeypatch.setitem(program.TUNING, name, value)
    text = ptx("DeviceSegments")
    stack, shared, grouped = 64, tuning.get(SHARED, 0), program.GROUP in tuning
    # Only groups exchange values, and each names its own lanes: no mask is a constant.
    masks = re.findall(r"\b(?:vote|shfl|bar\.warp)\.sync[^;]*,\s*(\S+);|bar\.warp\.sync\s+(\S+);", text)
    assert bool(masks) == grouped
    assert all((mask or other).startswith("%r") for mask, other in masks)
    # The stack is where it should be, and no entry is addressed without knowing where.
    assert bool(re.search(r"\bst\.shared\b", text)) == (shared > 0)
    assert bool(re.search(r"\bst\.local\b", text)) == (shared < stack)
    room = {int(n) for n in re.findall(r"\.shared .*entries\[(\d+)\]", text)}
    assert room == ({8 * shared * program.TUNING[program.BLOCK] // (16 if grouped else 1)} if shared else set())
    assert not re.search(r"\b(?:ld|st)(?:\.v2)?\.[ub]32", text)


def test_a_short_stack_that_is_too_long(monkeypatch: pytest.MonkeyPatch) -> None:
    require_nvrtc()
    monkeypatch.setitem(program.TUNING, SHARED, 64)
    with pytest.raises(AssertionError, match="FASTLINES_SHARED_STACK is too large: a block has 48 KB"):
        ptx("DeviceSegments")


@pytest.mark.parametrize(
    "arch", ["sm_90", *(pytest.param(arch, marks=pytest.mark.slow) for arch in ("sm_75", "sm_120"))]
)
def test_kernels_compile_and_are_cached(arch: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    require_nvrtc()
    monkeypatch.setenv("FASTLINES_CACHE", str(tmp_path / "cache"))
    code = program.compiled(arch, "DeviceSegments", 64)
    assert code[:4] == b"\x7fELF"
    assert len(code) < 10**6, "the loop over the children of a node is not unrolled"
    (cached,) = (tmp_path / "cache").iterdir()
    assert cached.read_bytes() == code
    cached.write_bytes(b"from the cache")
    assert program.compiled(arch, "DeviceSegments", 64) == b"from the cache"


@pytest.mark.slow
@pytest.mark.parametrize("arch", ["sm_75", "sm_120"])
def test_groups_compile(arch: str, monkeypatch: pytest.MonkeyPatch) -> None:
    require_nvrtc()
    monkeypatch.setitem(program.TUNING, program.GROUP, 16)
    monkeypatch.setitem(program.TUNING, SHARED, 16)
    assert program.compile_now(program.options(arch, "DeviceRoundCones", 64))[:4] == b"\x7fELF"


def test_other_programs_are_not_taken_from_the_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    require_nvrtc()
    monkeypatch.setenv("FASTLINES_CACHE", str(tmp_path))
    numbers = iter(range(9))
    monkeypatch.setattr(program, "compile_now", lambda how: b"%d" % next(numbers))

    def compiled() -> list[bytes]:
        kinds = ("sm_90", "DeviceSegments", 64), ("sm_90", "DeviceSegments", 128), ("sm_75", "DeviceSegments", 64)
        return [program.compiled(*kind) for kind in kinds]

    assert compiled() == [b"0", b"1", b"2"]
    monkeypatch.setitem(program.TUNING, program.GROUP, 16)
    assert compiled() == [b"3", b"4", b"5"]
    monkeypatch.setattr(program, "text", lambda: "other")
    assert compiled() == compiled() == [b"6", b"7", b"8"]


def test_a_cache_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    require_nvrtc()
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("FASTLINES_CACHE", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(program, "compile_now", lambda how: b"code")
    assert program.compiled("sm_90", "DeviceSegments", 64) == b"code"


def test_the_text_is_whole() -> None:
    """All that kernels include is in the package, and of the standard library no more than what NVRTC is given."""
    standard, core = map(Path, program.include_path())
    text = program.text()
    assert "class RoundConeTest" in text
    assert "inline Ray prepare(" in text
    assert set(re.findall(r"^#include <(.+)>", text, re.MULTILINE)) == {path.name for path in standard.iterdir()}
    assert (core / "fastlines" / "device" / "thread.hpp").read_text(encoding="utf-8") in text
    for name, value in program.TUNING.items():
        assert f"#define {name} {value}\n" in text


def test_a_package_without_headers(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(program, "_PACKAGE", tmp_path / "a" / "b")
    with pytest.raises(fl.FastlinesError, match="the text of the GPU's kernels is missing"):
        program.headers()


@pytest.mark.parametrize("platform", ["linux", "darwin", "win32"])
def test_cache_folder(platform: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("FASTLINES_CACHE", raising=False)
    monkeypatch.setattr("sys.platform", platform)
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    assert program.cache_folder().name == "fastlines"
    assert program.cache_folder().is_relative_to(tmp_path)
