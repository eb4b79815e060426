"""The libraries for LD_PRELOAD: compiled for a run, and called by the process that they are loaded in."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from pathlib import Path

from fastlines import InputError

#: What fails: the source of the library.
SOURCES = {"memory": "failing_memory.cpp", "files": "failing_files.cpp"}

#: Kinds of calls that the library for memory fails.
MEMORY, THREADS = 1, 2

#: The modules whose allocations count, by a part of their path. Those of NumPy do not: it reports that there is no
#: memory for the buffer of a ufunc without the GIL, which ends the process.
MODULES = ("/_core.", "/_engine", "/libstdc++")

#: All calls from one on.
ALL = 1 << 60


def compile_library(what: str, folder: Path) -> Path:
    """Compile one of the `SOURCES` into a folder; return the library."""
    compiler = next(filter(None, map(shutil.which, (os.environ.get("CXX", ""), "g++", "clang++"))), None)
    if compiler is None:
        raise InputError("there is no C++ compiler; faults are injected by a library that g++ or clang++ compiles")
    target = folder / f"failing_{what}.so"
    source = Path(__file__).with_name(SOURCES[what])
    command = [compiler, "-std=c++20", "-O1", "-shared", "-fPIC", str(source), "-o", str(target), "-ldl"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise InputError(f"{source} does not compile on this system: {done.stderr.strip().splitlines()[-1]}")
    return target


class FailingMemory:
    """The library for memory and threads, in a process that it is loaded in."""

    def __init__(self) -> None:
        self._calls = ctypes.CDLL(None)
        self._calls.faults_arm.argtypes = [ctypes.c_int, ctypes.c_long, ctypes.c_long]
        self._calls.faults_disarm.restype = ctypes.c_long
        self._calls.faults_watch.argtypes = [ctypes.c_char_p]
        counts = [self._calls.faults_watch(name.encode()) for name in MODULES]
        if sorted(set(counts)) != counts or not counts[0]:
            raise InputError(f"not all of the modules {', '.join(MODULES)} are loaded; build first")

    def arm(self, kind: int, first: int, last: int) -> None:
        """From now on calls first to last of a kind fail, counted from 1."""
        self._calls.faults_arm(kind, first, last)

    def disarm(self) -> int:
        """End that; return how many calls there were."""
        return int(self._calls.faults_disarm())


class FailingFiles:
    """The library for files, in a process that it is loaded in."""

    def __init__(self) -> None:
        self._calls = ctypes.CDLL(None)
        self._calls.faults_arm.argtypes = [ctypes.c_char_p, ctypes.c_int, ctypes.c_long, ctypes.c_long]
        self._calls.faults_disarm.restype = ctypes.c_long
        self._calls.faults_failed.restype = ctypes.c_char_p

    def arm(self, folder: Path, error: int, first: int, last: int) -> None:
        """From now on calls first to last that change files below a folder fail with an error number."""
        self._calls.faults_arm(os.fsencode(os.path.realpath(folder)), error, first, last)

    def disarm(self) -> tuple[int, str]:
        """End that; return how many calls there were, and which one failed first."""
        return int(self._calls.faults_disarm()), self._calls.faults_failed().decode()
