"""What is installed: version, instruction sets, threads, the library for C++, extras."""

from __future__ import annotations

import importlib.util
import platform
from typing import Any

import fastlines as fl

from ..engines import compiled_simd
from ..errors import FastlinesError

#: A module of each extra.
EXTRAS = {
    "arrow": "pyarrow",
    "cad": "ezdxf",
    "cuda": "cuda",
    "exr": "OpenEXR",
    "molecules": "gemmi",
    "nifti": "nibabel",
    "pyvista": "pyvista",
    "usd": "pxr",
    "video": "imageio_ffmpeg",
}


def describe_installation() -> dict[str, Any]:
    """Return what is installed, by name; `error` says why no instruction set can be used."""
    simd = error = None
    try:
        simd = fl.simd()
    except FastlinesError as why:
        error = str(why)
    try:
        library = fl.get_lib()
    except FastlinesError:
        library = None
    extras = {extra: importlib.util.find_spec(module) is not None for extra, module in EXTRAS.items()}
    return {
        "version": fl.__version__,
        "python": platform.python_version(),
        "simd": simd,
        "error": error,
        "compiled": list(compiled_simd()),
        "threads": fl.get_num_threads(),
        "library": library,
        "extras": [extra for extra, found in extras.items() if found],
        "missing": [extra for extra, found in extras.items() if not found],
    }


def installation_text(found: dict[str, Any]) -> str:
    """Return what is installed as lines of text."""
    rows = {
        "instruction set": found["simd"] or found["error"],
        "compiled for": ", ".join(found["compiled"]) or "none",
        "threads": found["threads"],
        "library for C++": found["library"] or "not installed",
        "extras": ", ".join(found["extras"]) or "none",
        "missing extras": ", ".join(found["missing"]) or "none",
    }
    head = f"fastlines {found['version']}, Python {found['python']}"
    return "\n".join([head, *(f"  {name:<16} {value}" for name, value in rows.items())])
