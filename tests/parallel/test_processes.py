"""Trees in other processes: a fork goes on with them, and a process that is started anew gets them as pickles."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same
from support.patience import HANGS

import fastlines as fl

#: What else the process does while it forks.
MEANWHILE = {
    "alone": "",
    "a thread queries": "threading.Thread(target=lambda: [ask() for _ in iter(over.is_set, True)]).start()",
}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="fork")
@pytest.mark.parametrize("meanwhile", MEANWHILE)
def test_a_fork_answers_as_its_parent(meanwhile: str) -> None:
    """Queries and builds in several threads go before the fork, and follow in it."""
    program = f"""
import os, threading, warnings
import numpy as np, fastlines as fl

warnings.simplefilter("ignore", DeprecationWarning)  # Python warns of forks beside threads
random = np.random.default_rng(0)
many = random.random((3000, 2, 3)).astype(np.float32)
rays = random.uniform(-1, 1, (2, 6000, 3)).astype(np.float32)
fl.set_num_threads(3)
tree, over = fl.build(many), threading.Event()

def ask():
    hits = tree.all_hits(*rays, 0.02)
    return [column.tobytes() for column in (hits.offsets, hits.t, hits.prim, hits.u, hits.distance)]

expected, nodes = ask(), tree.nodes.tobytes()
{MEANWHILE[meanwhile]}
codes = []
for _ in range(4):
    child = os.fork()
    if not child:
        os._exit(0 if ask() == expected and fl.build(many).nodes.tobytes() == nodes else 3)
    codes.append(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
over.set()
print(codes, ask() == expected)
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=HANGS, check=False)
    assert (ended.stdout, ended.stderr) == ("[0, 0, 0, 0] True\n", "")


def test_a_process_that_is_started_anew_answers_from_a_pickle() -> None:
    random = np.random.default_rng(0)
    tree, rays = fl.build(random.random((300, 2, 3))), random.uniform(-1, 1, (2, 300, 3))
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        found = pool.submit(ask, tree, rays).result(HANGS)
    assert_same(found, tree.all_hits(*rays, 0.1))


def ask(tree: fl.Tree, rays: Any) -> fl.AllHits:
    return tree.all_hits(*rays, 0.1)
