"""The end of Python while threads query, build or report progress."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from support.patience import HANGS
from support.slow import few_of

import fastlines as fl

#: What a thread may be in when Python ends; `tell` is a progress callback.
UNDER_WAY = {
    "query": "tree.all_hits(*rays, 0.05)",
    "query of few rays": "tree.first_hit(*(array[:5] for array in rays), 0.05)",
    "binary search": "tree.count_hits(*rays, 0.05, kernel='binary')",
    "brute force": "fl.brute_force(many, *rays, 0.01)",
    "build": "fl.build(many, 'bvh-d2')",
    "reinsertion": "fl.build(many, 'bvh-cl', reinsertion=50)",
    "layout": "fl.build(many, splits=fl.Median()).layout",
    "refit": "tree.refit(many)",
    "validate": "tree.validate()",
    "progress of a build": "fl.build(many, 'bvh-d2', progress=tell)",
    "progress of a query": "fl.brute_force(many, *rays, 0.01, progress=tell)",
    "places of hits": "tree.first_hit(*rays, 0.05, at='surface').normals()",
    "query that ignores": "tree.first_hit(*rays, 0.05, ignore=np.arange(2000))",
    "query of a Geometry": "parts.all_hits(*rays, 0.05, at='surface', merge='strand').points()",
    "query of a class of the user's": "balls.count_hits(*(array[:30] for array in rays), 0.05)",
}


def end_with_threads(call: str, start: str) -> None:
    """Run a process that starts threads as `start` says, and ends as soon as one has entered the call."""
    program = f"""
import sys, threading, time
from concurrent.futures import ThreadPoolExecutor
import numpy as np, fastlines as fl

class Last:
    def __del__(self, sleep=time.sleep):
        sleep(0.2)  # Python is ending, and other threads may try to go on

class Balls:
    def __init__(self, centres):
        self.centres = centres

    def bounds(self):
        return np.stack([self.centres - 0.05, self.centres + 0.05], axis=1)

    def hit(self, ids, rays, radius):
        to, along = self.centres[ids] - rays.origins, rays.directions
        t = (to * along).sum(axis=1) / (along * along).sum(axis=1)
        gap = np.linalg.norm(t[:, None] * along - to, axis=1)
        return np.where(gap <= 0.05 + radius, t, np.inf)

random = np.random.default_rng(0)
many = random.random((5000, 2, 3)).astype(np.float32)
rays = random.uniform(-1, 1, (2, 3000, 3)).astype(np.float32)
tree, balls = fl.build(many), fl.build(Balls(many[:500, 0].astype(float)))
parts = fl.build(fl.Geometry([fl.lines(many), fl.Triangles(random.random((500, 3, 3)))]))
entered, over, sys.last = threading.Event(), threading.Event(), Last()

def tell(share):
    entered.set()
    sum(range(100_000))

def run():
    while not over.is_set():
        if {"progress" not in call}:
            entered.set()
        {call}

{start}
entered.wait()
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=HANGS, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.parametrize("what", few_of(UNDER_WAY, n=1))
def test_python_ends_while_a_daemon_thread_works(what: str) -> None:
    for _ in range(2):
        end_with_threads(UNDER_WAY[what], "for _ in range(4): threading.Thread(target=run, daemon=True).start()")


@pytest.mark.parametrize("what", few_of(["query", "progress of a build"], n=1))
@pytest.mark.parametrize("start", ["threading.Thread(target=run).start()", "ThreadPoolExecutor(3).submit(run)"])
def test_python_waits_for_threads_that_are_no_daemons(what: str, start: str) -> None:
    end_with_threads(UNDER_WAY[what], f"{start}\nthreading.Timer(0.2, over.set).start()")


@pytest.mark.parametrize("what", ["query of a class of the user's", "query of a Geometry"])
def test_no_end_aborts_in_code_of_numpy(what: str) -> None:
    """NumPy's own C++ may wait for the GIL, too; one end in four aborted there."""
    for _ in range(6):
        end_with_threads(UNDER_WAY[what], "for _ in range(4): threading.Thread(target=run, daemon=True).start()")


def test_queries_do_not_use_what_aborts() -> None:
    """`support/distinct.py` says why, and has what to use instead."""
    for folder in ("query", "geometry"):
        for path in (Path(fl.__file__).parent / folder).rglob("*.py"):
            calls = [
                node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Call)
            ]
            hashing = [
                call for call in calls if ast.unparse(call.func) in ("np.unique", "np.isin") and not call.keywords
            ]
            assert not hashing, (path, ast.unparse(hashing[0]))
