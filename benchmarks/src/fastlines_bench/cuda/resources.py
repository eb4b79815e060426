"""The registers and the memory that a thread of each kernel needs, as NVRTC reports them. No GPU is needed."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

from ..harness import machine
from ..harness.internals import cuda_program, optional
from ..harness.preset import Preset, sized
from .variants import VARIANTS, Variant, tuned

#: The kernels that are shown.
KERNELS = ("first_closest", "any_hit", "count_hits", "all_closest")


@dataclass(frozen=True, kw_only=True)
class ResourcesPreset(Preset):
    """What is compiled.

    Parameters
    ----------
    arch : str
        The architecture, such as "sm_90".
    primitives : str
    stack : int
        The entries of a stack.
    variants : tuple of dict of str to int
    """

    arch: str = "sm_90"
    primitives: str = "DeviceSegments"
    stack: int = 64
    variants: tuple[Variant, ...] = sized(VARIANTS, VARIANTS[:1])


@dataclass(frozen=True)
class KernelResources:
    """The registers of a thread, its bytes of local memory and of spills there, and the shared memory of a block."""

    variant: Variant
    kernel: str
    registers: int
    local: int
    spills: int
    shared: int


@dataclass
class ResourcesResult:
    """All figures."""

    preset: ResourcesPreset
    compiler: str
    machine: dict[str, object]
    rows: list[KernelResources] = field(default_factory=list)

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON."""
        return asdict(self) | {"format": "fastlines-bench cuda-resources 1"}


def run_resources(preset: ResourcesPreset, progress: Callable[[str, float], None]) -> ResourcesResult:
    """Compile all variants. Raises an error if NVRTC is not installed."""
    nvrtc = optional("cuda.bindings.nvrtc", "the compiler of kernels", "cuda")
    version = ".".join(map(str, nvrtc.nvrtcVersion()[1:]))
    result = ResourcesResult(preset, f"NVRTC {version}", machine.describe())
    for i, variant in enumerate(preset.variants):
        progress(f"variant {i + 1}", i / len(preset.variants))
        result.rows += parse(variant, compile_log(preset, variant))
    return result


def compile_log(preset: ResourcesPreset, variant: Variant) -> str:
    """Compile a variant; return what the assembler says of each kernel."""
    core = optional("cuda.core", "the compiler of kernels", "cuda")
    with tuned(variant):
        how = cuda_program.options(preset.arch, preset.primitives, preset.stack) | {"ptxas_options": ["-v"]}
    log = io.StringIO()
    core.Program(cuda_program.SOURCE, "c++", core.ProgramOptions(**how)).compile("cubin", logs=log)
    return log.getvalue()


def parse(variant: Variant, log: str) -> list[KernelResources]:
    """Return the resources of `KERNELS`, from the log of a compilation.

    Examples
    --------
    >>> log = '''ptxas info    : Compiling entry function 'any_hit' for 'sm_90'
    ... ptxas info    : Function properties for any_hit
    ...     512 bytes stack frame, 12 bytes spill stores, 8 bytes spill loads
    ... ptxas info    : Used 72 registers, used 0 barriers, 512 bytes cumulative stack size, 1024 bytes smem'''
    >>> parse({}, log)
    [KernelResources(variant={}, kernel='any_hit', registers=72, local=512, spills=12, shared=1024)]
    """
    patterns = r"Used (\d+) registers", r"(\d+) bytes stack frame", r"(\d+) bytes spill stores", r"(\d+) bytes smem"
    found = {}
    for part in log.split("Compiling entry function '")[1:]:
        matches = [re.search(pattern, part) for pattern in patterns]
        found[part.partition("'")[0]] = [0 if match is None else int(match[1]) for match in matches]
    return [KernelResources(variant, kernel, *found[kernel]) for kernel in KERNELS if kernel in found]
