"""Loops in C++ that are compiled on first use."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from pathlib import Path

import fastlines as fl


def compile_loops(source: Path, what: str, *flags: str) -> ctypes.CDLL:
    """Compile a file as a library, and load it.

    Parameters
    ----------
    source : Path
    what : str
        What the file holds, for errors.
    *flags : str
        More flags of the compiler.

    Raises
    ------
    FastlinesError
        If there is no compiler, or if it fails.
    """
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None:
        raise fl.FastlinesError(f"{what} need a compiler: install g++")
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "loops.so"
        command = [compiler, "-std=c++20", "-shared", "-fPIC", str(source), *flags, "-o", str(library)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise fl.FastlinesError(f"{what} cannot be compiled: {done.stderr.strip()[-500:]}")
        return ctypes.CDLL(str(library))
