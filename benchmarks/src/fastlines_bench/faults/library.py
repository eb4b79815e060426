"""The libraries for LD_PRELOAD: compiled for a run, and called by the process that they are loaded in."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from pathlib import Path

import fastlines as fl
from fastlines import InputError

#: The libraries for LD_PRELOAD, by the calls that fail.
SOURCES = {"memory": "failing_memory.cpp", "files": "failing_files.cpp"}

#: The program whose allocations fail, with the library for C++ and C.
PROGRAM = "library_worker.cpp"

#: Kinds of calls that the library for memory fails, and that for files.
MEMORY, THREADS = 1, 2
CHANGES, READS = 1, 2

#: The modules whose allocations count, by a part of their path. Those of NumPy do not: it reports that there is no
#: memory for the buffer of a ufunc without the GIL, which ends the process.
MODULES = ("/_core.", "/_engine", "/libstdc++")

#: All calls from one on.
ALL = 1 << 60


def compile_library(what: str, folder: Path) -> Path:
    """Compile one of the `SOURCES` into a folder; return the library."""
    target = folder / f"failing_{what}.so"
    _compile(SOURCES[what], target, "-shared", "-fPIC")
    return target


def compile_program(folder: Path) -> Path:
    """Compile the program with the library of the package into a folder; return the program."""
    target, libraries = folder / "library_worker", Path(fl.get_lib())
    (library,) = {path.resolve() for path in libraries.glob("libfastlines.so*")}
    _compile(PROGRAM, target, f"-I{fl.get_include()}", str(library), f"-Wl,-rpath,{libraries}", "-pthread")
    return target


def _compile(name: str, target: Path, *options: str) -> None:
    compiler = next(filter(None, map(shutil.which, (os.environ.get("CXX", ""), "g++", "clang++"))), None)
    if compiler is None:
        raise InputError("there is no C++ compiler; faults are injected by a library that g++ or clang++ compiles")
    source = Path(__file__).with_name(name)
    command = [compiler, "-std=c++20", "-O1", str(source), *options, "-o", str(target), "-ldl"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise InputError(f"{source} does not compile on this system: {done.stderr.strip().splitlines()[-1]}")


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
        numbers = [ctypes.c_int, ctypes.c_long, ctypes.c_long]
        self._calls.faults_arm.argtypes = [ctypes.c_int, ctypes.c_char_p, *numbers]
        self._calls.faults_disarm.restype = ctypes.c_long
        self._calls.faults_failed.restype = ctypes.c_char_p

    def arm(self, kind: int, folder: Path, error: int, first: int, last: int) -> None:
        """From now on calls first to last of a kind, on a folder and files below it, fail with an error number.

        Reads fail with 0 by reading half.
        """
        self._calls.faults_arm(kind, os.fsencode(os.path.realpath(folder)), error, first, last)

    def disarm(self) -> tuple[int, str]:
        """End that; return how many calls there were, and which one failed first."""
        return int(self._calls.faults_disarm()), self._calls.faults_failed().decode()
