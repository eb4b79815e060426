"""Lists of hits that can not fit into memory are refused by a sample of their rays, and no others."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.patience import HANGS

import fastlines as fl
from fastlines.query import memory_check
from fastlines.query.memory_check import AT_ONCE, LATEST, MOST, ONE_OF, MemoryCheck, left_memory
from fastlines.threads import num_threads

N_RAYS = 1_000_000
RNG = np.random.default_rng(0)
LINES = RNG.uniform(-1, 1, (3000, 2, 3)).astype(np.float32)
TREE = fl.build(LINES)


@pytest.fixture
def left(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Return a function that sets how many bytes are left."""

    def set_left(n_bytes: float) -> None:
        monkeypatch.setattr(memory_check, "left_memory", lambda: n_bytes)

    return set_left


# ---- What is left ----


def machine(root: Path, files: dict[str, str]) -> float:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return left_memory(root)


MEMINFO = {"proc/meminfo": "MemTotal:  9000 kB\nMemAvailable:    5000 kB\nSwapTotal: 800 kB\nSwapFree:   700 kB\n"}


def test_what_the_machine_has_left(tmp_path: Path) -> None:
    assert machine(tmp_path / "unknown", {}) == math.inf
    assert machine(tmp_path / "known", MEMINFO) == 5700 * 1024
    assert left_memory() > 0


def test_what_groups_leave(tmp_path: Path) -> None:
    """Version 2: the group sets no limit, the one above it does, and half of what that uses is cached files."""
    above, top = "sys/fs/cgroup/a", "sys/fs/cgroup"
    files = MEMINFO | {
        "proc/self/cgroup": "0::/a/b c\n",
        f"{above}/b c/memory.max": "max\n",
        f"{above}/b c/memory.current": "1000000\n",
        f"{above}/memory.max": "3000000\n",
        f"{above}/memory.current": "2000000\n",
        f"{above}/memory.stat": "anon 1000000\nfile 5\ninactive_file 900000\nactive_file 100000\n",
        f"{top}/cgroup.controllers": "memory\n",
    }
    assert machine(tmp_path, files) == 2_000_000 + 700 * 1024
    # A container sees its own group at the top.
    own = {"proc/self/cgroup": "0::/\n", f"{top}/memory.max": "1500000\n", f"{top}/memory.current": "1000000\n"}
    assert machine(tmp_path, own) == 500_000 + 700 * 1024


def test_what_groups_of_version_1_leave(tmp_path: Path) -> None:
    top = "sys/fs/cgroup/memory"
    files = MEMINFO | {
        "proc/self/cgroup": "12:pids:/x\n9:cpu,memory:/docker/0123\nno such line\n1:name=systemd:/\n0::/\n",
        f"{top}/memory.limit_in_bytes": "4000000\n",
        f"{top}/memory.usage_in_bytes": "2000000\n",
        f"{top}/memory.stat": "inactive_file 7\ntotal_inactive_file 500000\ntotal_active_file 250000\n",
    }
    assert machine(tmp_path, files) == 2_750_000 + 700 * 1024
    (tmp_path / top / "memory.limit_in_bytes").write_text("9223372036854771712\n", encoding="utf-8")
    assert left_memory(tmp_path) == 5700 * 1024


# ---- The rule ----


def looks(n_rays: int, counts: Callable[[Any], Any]) -> MemoryCheck:
    """Look as often as a query of an hour."""
    found = MemoryCheck(n_rays, 20, counts)
    for i in range(1000):
        found.look(LATEST * i / 1000)
    return found


def test_the_same_hits_for_each_ray(left: Callable[[float], None]) -> None:
    def all_alike(rows: Any) -> Any:
        return np.full(len(rows), 5000)

    left(20 * 5000 * N_RAYS * 0.4)
    with pytest.raises(MemoryError, match=r"sample of 16 rays .* about 5,000 million .* 100.0 GB, 40.0 GB are left"):
        looks(N_RAYS, all_alike)
    left(20 * 5000 * N_RAYS)
    assert looks(N_RAYS, all_alike).why == ""
    # A small answer is not refused, whatever is said to be left, nor is one late: what it takes may have been taken.
    left(0)
    looks(1000, all_alike)
    MemoryCheck(N_RAYS, 20, all_alike).look(0.3)
    with pytest.raises(MemoryError):
        MemoryCheck(N_RAYS, 20, all_alike).look(0.2)


@pytest.mark.parametrize("share", [0.0001, 0.003, 0.01, 0.1, 0.5])
def test_what_just_fits_is_not_refused_by_bad_luck(share: float, left: Callable[[float], None]) -> None:
    """This fraction of the rays hit a million segments, the others none."""
    left(20 * share * 1e6 * N_RAYS)
    for seed in range(300):
        random = np.random.default_rng(seed)
        assert looks(N_RAYS, lambda rows: (random.random(len(rows)) < share) * 1_000_000).why == ""  # noqa: B023


def test_a_sample_is_small_and_spread(left: Callable[[float], None]) -> None:
    for n_rays in (1, 100, 256, 1000, N_RAYS, 2**32 - 1):
        asked: list[int] = []
        calls: list[int] = []

        def count(rows: Any) -> Any:
            asked.extend(rows.tolist())  # noqa: B023
            calls.append(len(rows))  # noqa: B023
            return np.zeros(len(rows), np.int64)

        looks(n_rays, count)
        assert len(asked) <= min(MOST, n_rays / ONE_OF)
        assert (len(asked) >= AT_ONCE) == (n_rays >= AT_ONCE * ONE_OF)
        assert max(calls, default=0) <= AT_ONCE
        assert all(0 <= row < n_rays for row in asked)
        for n in calls[:1] if asked else ():  # after the first look too
            assert np.diff(sorted({0, n_rays, *asked[:n]})).max() < n_rays / 5


def test_a_sample_that_can_not_be_taken_refuses_nothing(left: Callable[[float], None]) -> None:
    def full(rows: Any) -> Any:
        raise MemoryError

    left(0)
    assert looks(N_RAYS, full).why == ""


# ---- Queries ----

WIDE = RNG.uniform(-1, 1, (2, 200_000, 3)).astype(np.float32)
ASK: dict[str, Callable[..., fl.AllHits]] = {
    "layout": lambda *rays, **more: TREE.all_hits(*rays, **more),
    "one by one": lambda *rays, **more: TREE.all_hits(*rays, **more, kernel="single", at="surface"),
    "binary": lambda *rays, **more: TREE.all_hits(*rays, **more, kernel="binary"),
    "brute force": lambda *rays, **more: fl.brute_force(LINES, *rays, **more),
    "next": lambda *rays, **more: TREE.next_hits(*rays, 2500, **more),
}


@pytest.mark.parametrize("ask", ASK)
def test_a_query_is_refused_at_its_beginning(ask: str, left: Callable[[float], None]) -> None:
    """Its answer would be 10 GB."""

    def tell(share: float) -> None:
        assert share < 0.1

    left(1e9)
    says = r"hits of 200,000 rays do not fit .*by a sample of .* million .* 1.0 GB are left; trace fewer rays"
    with num_threads(1), pytest.raises(MemoryError, match=says):
        ASK[ask](*WIDE, 10.0, progress=tell)


@pytest.mark.parametrize("ask", ASK)
def test_a_query_that_fits_is_not_refused(
    ask: str, left: Callable[[float], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    rays = WIDE[:, :1000]
    expected = ASK[ask](*rays, 0.5)
    monkeypatch.setattr(memory_check, "SMALL", 0)
    left(20 * len(expected.prim))
    found = ASK[ask](*rays, 0.5)
    for name in ("offsets", "t", "prim", "u", "distance"):
        assert getattr(found, name).tobytes() == getattr(expected, name).tobytes()


@pytest.mark.slow
def test_the_k_nearest_that_fit_are_not_refused(left: Callable[[float], None], monkeypatch: pytest.MonkeyPatch) -> None:
    rays = WIDE[:, :2000]
    monkeypatch.setattr(memory_check, "SMALL", 0)
    left(20 * 2 * 2000)  # all hits would take a thousand times as much
    assert (TREE.next_hits(*rays, 10.0, 2).counts == 2).all()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="needs a limit on memory")
def test_a_limit_on_addresses_is_known() -> None:
    program = """
import resource
import numpy as np, fastlines as fl

random = np.random.default_rng(0)
tree = fl.build(random.random((20_000, 2, 3)))
rays = random.uniform(-1, 1, (2, 300_000, 3))
fl.set_num_threads(1)
tree.any_hit(*rays, 0.01)
with open("/proc/self/statm") as file:
    used = int(file.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (2 << 30),) * 2)
try:
    tree.all_hits(*rays, 2.0)
except MemoryError as error:
    print(error)
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=HANGS, check=False)
    assert ended.returncode == 0, ended.stderr[-1000:]
    assert re.search(r"by a sample of 16 rays they are about .* million and take .* GB, [12]\.\d GB are", ended.stdout)
