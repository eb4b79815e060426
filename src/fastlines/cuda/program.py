"""The text of the kernels, and its compilation by NVRTC, cached on disk."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import sys
from pathlib import Path
from typing import Any

from ..errors import FastlinesError
from ..support.atomic_write import atomic_write

#: The folder of the package.
_PACKAGE = Path(__file__).resolve().parents[1]

#: What NVRTC compiles.
SOURCE = '#include "fastlines/device/kernels.hpp"\n'

#: NVRTC does not know [[gnu::always_inline]].
_UNKNOWN_ATTRIBUTE = 1097

#: Threads of a block.
BLOCK = "FASTLINES_BLOCK"

#: Threads that take a ray.
GROUP = "FASTLINES_GROUP"

#: Macros that change the speed of kernels and no answer; `fastlines-bench cuda-variants` sets them. The values are
#: those of cpp/fastlines/device, which nobody has measured yet.
TUNING: dict[str, int] = {BLOCK: 128, GROUP: 1, "FASTLINES_NODE_ROWS": 0, "FASTLINES_SHARED_STACK": 0}


def headers() -> Path:
    """Return the folder with the headers of the core: installed with the package, or of the source folder.

    Raises
    ------
    FastlinesError
        If there is none.
    """
    for folder in (_PACKAGE / "include", _PACKAGE.parents[1] / "cpp"):
        if (folder / "fastlines" / "device" / "kernels.hpp").is_file():
            return folder
    raise FastlinesError(
        f"the text of the GPU's kernels is missing: there is no folder {_PACKAGE / 'include'}; install the package "
        "with pip install ."
    )


def include_path() -> list[str]:
    """Return the folders that NVRTC searches: the few names of the standard library, and the headers."""
    return [str(_PACKAGE / "cuda" / "std"), str(headers())]


def text() -> str:
    """Return all text that is compiled: that of the kernels, and of what they include."""
    standard, core = map(Path, include_path())
    seen: dict[Path, str] = {}
    waiting = [core / "fastlines" / "device" / "kernels.hpp"]
    while waiting:
        path = waiting.pop().resolve()
        if path in seen:
            continue
        seen[path] = path.read_text(encoding="utf-8")
        waiting += [path.parent / name for name in re.findall(r'^#include "(.+)"', seen[path], re.MULTILINE)]
        waiting += [standard / name for name in re.findall(r"^#include <(.+)>", seen[path], re.MULTILINE)]
    return "\n".join(seen[path] for path in sorted(seen))


def macros(primitives: str, stack: int) -> list[tuple[str, str]]:
    """Return the macros for a kind of primitive and the entries of a stack."""
    tuning = [(name, str(value)) for name, value in TUNING.items()]
    return [("FASTLINES_PRIMITIVES", primitives), ("FASTLINES_STACK", str(stack)), *tuning]


def options(arch: str, primitives: str, stack: int) -> dict[str, Any]:
    """Return the options of NVRTC. Those of arithmetic keep the bits of the CPU: each operation is rounded once."""
    return {
        "std": "c++20",
        "arch": arch,
        "fma": False,
        "ftz": False,
        "prec_div": True,
        "prec_sqrt": True,
        "device_as_default_execution_space": True,
        "diag_suppress": [_UNKNOWN_ATTRIBUTE],
        "include_path": include_path(),
        "define_macro": macros(primitives, stack),
    }


def compiled(arch: str, primitives: str, stack: int) -> bytes:
    """Return the kernels as machine code for an architecture such as "sm_90", from the cache if they are there."""
    from cuda.bindings import nvrtc

    how = options(arch, primitives, stack)
    described = [str(nvrtc.nvrtcVersion()), arch, str(how["define_macro"]), text()]
    key = hashlib.sha256("\0".join(described).encode()).hexdigest()[:32]
    path = cache_folder() / f"{key}.cubin"
    with contextlib.suppress(OSError):
        return path.read_bytes()
    code = compile_now(how)
    # A folder that cannot be written only costs the next process a compilation.
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as partial:
            partial.write_bytes(code)
    return code


def compile_now(how: dict[str, Any]) -> bytes:
    """Compile the kernels, with these options."""
    from cuda.core import Program, ProgramOptions

    return bytes(Program(SOURCE, "c++", ProgramOptions(**how)).compile("cubin").code)


def cache_folder() -> Path:
    """Return the folder of compiled kernels: that of the variable FASTLINES_CACHE, or one in the user's cache."""
    given = os.environ.get("FASTLINES_CACHE")
    if given:
        return Path(given)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "fastlines"
