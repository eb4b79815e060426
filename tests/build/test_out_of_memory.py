"""Builds and merges whose allocations fail one after another: a MemoryError each time, and the process lives."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "benchmarks" / "src" / "fastlines_bench" / "faults" / "failing_memory.cpp"
SCRIPT = """
import ctypes
import numpy as np
import fastlines as fl

rng = np.random.default_rng(1)
lines = fl.lines(rng.random((40, 2, 3)))
tree = fl.build(lines, "bvh-cl")
library = ctypes.CDLL(None)
library.faults_arm.argtypes = [ctypes.c_int, ctypes.c_long, ctypes.c_long]
library.faults_disarm.restype = ctypes.c_long
library.faults_watch.argtypes = [ctypes.c_char_p]
for name in (b"/_core.", b"/_engine", b"/libstdc++"):
    library.faults_watch(name)
fl.set_num_threads(1)
both = fl.Geometry([lines, fl.lines(rng.random((20, 2, 3)))])
whole = fl.build(both)
calls = {
    "build": lambda: fl.build(lines, "bvh-cl").areas,
    "nearest": lambda: tree.nearest(rng.random((3, 3)), ignore=[1]).prim[:0],
    "pairs": lambda: whole.pairs(0.1).i,
}
for name, call in calls.items():
    expected, n, n_calls = call(), 0, 1
    while n < n_calls:
        n += 1
        library.faults_arm(1, n, n)
        error = None
        try:
            found = call()
        except MemoryError as caught:
            error = caught
        n_calls = library.faults_disarm()
        assert error is not None or np.array_equal(found, expected), (name, n)
    assert np.array_equal(call(), expected), name
    print(name, n)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="allocations fail by LD_PRELOAD, on Linux")
def test_each_allocation_fails(tmp_path):
    compiler = shutil.which(os.environ.get("CXX", "g++"))
    if compiler is None:
        pytest.skip("there is no C++ compiler")
    library = tmp_path / "failing_memory.so"
    command = [compiler, "-std=c++20", "-shared", "-fPIC", str(SOURCE), "-o", str(library), "-ldl"]
    subprocess.run(command, check=True)
    environment = {**os.environ, "LD_PRELOAD": str(library)}
    done = subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    counts = dict(line.split() for line in done.stdout.splitlines())
    assert set(counts) == {"build", "nearest", "pairs"}
    assert all(int(n) > 3 for n in counts.values())
