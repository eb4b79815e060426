"""Long calls leave Python free to run, tell how far they are, and end on Ctrl-C or when a callback raises."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.patience import HANGS
from support.slow import few_of

import fastlines as fl
from fastlines.structure.layout import build_layout

RNG = np.random.default_rng(0)
LINES = nasty.crossing(RNG, 20_000).astype(np.float32)
FEW = LINES[:3000]
RAYS = nasty.from_distance(1)(RNG, LINES.astype(float), 20_000, 2.0)
MANY = tuple(np.tile(rays, (20, 1)) for rays in RAYS)
POINTS = RNG.uniform(-1, 1, (60_000, 3))
TREE = fl.build(FEW, "bvh-cl")

#: Calls of a few tenths of a second or more.
LONG: dict[str, Callable[..., Any]] = {
    "build": lambda **more: fl.build(LINES[:2000], "bvh-d2", **more),
    "build kd": lambda **more: fl.build(LINES[:1500], "kd-d2", **more),
    "brute force": lambda **more: fl.brute_force(FEW, *RAYS, 0.01, query="count_hits", **more),
    "first hit": lambda **more: TREE.first_hit(*MANY, 0.001, **more),
    "all hits": lambda **more: TREE.all_hits(*(rays[:80_000] for rays in MANY), 0.05, **more),
    "nearest": lambda **more: TREE.nearest(POINTS, **more),
    "k nearest": lambda **more: TREE.nearest(POINTS, 8, **more),
    "within": lambda **more: TREE.within(POINTS, 0.1, **more),
    "count within": lambda **more: TREE.count_within(POINTS, 0.1, **more),
    "brute force of points": lambda **more: fl.brute_force_points(FEW, POINTS[:10_000], **more),
}


@pytest.fixture(autouse=True)
def one_thread() -> Any:
    fl.set_num_threads(1)
    yield
    fl.set_num_threads(None)


@pytest.mark.parametrize("call", LONG)
def test_gil_is_released(call: str) -> None:
    """Another thread ticks during a call. It may do so once or twice while Python goes into the call and comes back."""
    ticks: Counter[int] = Counter()
    n_calls, during, stop = 0, 0, threading.Event()

    def tick() -> None:
        while not stop.wait(0.001):
            ticks[during] += 1

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        while ticks[n_calls] <= 3 or n_calls == 0:  # a busy machine may let it wait for all of a call, but not of many
            n_calls += 1
            assert n_calls <= 100, "no other thread runs during a call"
            during = n_calls
            LONG[call]()
            during = 0
    finally:
        stop.set()
        thread.join()


@pytest.mark.parametrize("n_threads", few_of([1, 4], n=1))
@pytest.mark.parametrize("call", LONG)
def test_progress_rises_from_0_to_1(call: str, n_threads: int) -> None:
    fl.set_num_threads(n_threads)
    seen: list[float] = []
    LONG[call](progress=seen.append)
    assert len(seen) >= 1
    assert all(type(share) is float for share in seen)
    assert seen == sorted(seen)
    assert 0 <= seen[0] <= seen[-1] <= 1
    assert seen[-1] > 0


@pytest.mark.parametrize("call", LONG)
def test_exception_of_the_callback_ends_the_call(call: str) -> None:
    class StopHereError(Exception):
        pass

    seen: list[float] = []

    def refuse(share: float) -> None:
        seen.append(share)
        raise StopHereError(share)

    with pytest.raises(StopHereError):
        LONG[call](progress=refuse)
    assert len(seen) == 1
    assert seen[0] < 1
    # And nothing is left of it.
    some = RAYS[0][:200], RAYS[1][:200], 0.01
    assert TREE.count_hits(*some).tolist() == fl.brute_force(FEW, *some, query="count_hits").tolist()


def test_progress_true_shows_a_bar(capfd: pytest.CaptureFixture[str]) -> None:
    tree = fl.build(LINES[:3000], "bvh-cl", progress=True)
    assert tree.n_prims == 3000
    assert capfd.readouterr().out == ""


def test_callback_of_a_small_call_may_ask_queries_itself() -> None:
    seen: list[int] = []
    fl.build(LINES[:2000], "bvh-d2", progress=lambda _: seen.append(TREE.count_hits([0, 0, -5], [0, 0, 1], 0.1)))
    assert seen
    assert len({int(n) for n in seen}) == 1


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="cores can not be chosen here")
def test_threads_keep_to_the_cores_that_the_process_may_use() -> None:
    """A thread is started away from the core of whoever starts it; where there is no other, on that one."""
    code = """if True:
        import os, sys, threading, time

        if sys.argv[1] == "one":
            os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
        import fastlines as fl

        may_use, lines = os.sched_getaffinity(0), fl.scenes.make("spaghetti", 5000).lines
        seen, over = set(), threading.Event()

        def look():
            while not over.is_set():
                for task in os.listdir("/proc/self/task"):
                    try:
                        seen.add(frozenset(os.sched_getaffinity(int(task))))
                    except OSError:
                        pass
                time.sleep(0.002)

        looking = threading.Thread(target=look)
        looking.start()
        fl.set_num_threads(4)
        for _ in range(10):
            fl.build(lines)
        over.set()
        looking.join()
        assert os.sched_getaffinity(0) == may_use
        assert frozenset(may_use) in seen
        assert all(cores <= may_use for cores in seen), seen
    """
    for cores in ("one", "all"):
        subprocess.run([sys.executable, "-c", code, cores], check=True, timeout=HANGS)


def test_queries_from_many_threads() -> None:
    """One tree, asked by eight Python threads at once, while another is built."""
    rays = [array[:600] for array in RAYS]
    expected, nearest = TREE.all_hits(*rays, 0.01), TREE.nearest(POINTS[:2000], 3)
    wrong: list[object] = []

    def ask() -> None:
        for _ in range(5):
            try:
                got = TREE.all_hits(*rays, 0.01)
                if got.prim.tobytes() != expected.prim.tobytes() or got.t.tobytes() != expected.t.tobytes():
                    wrong.append("another answer")
                if TREE.nearest(POINTS[:2000], 3).prim.tobytes() != nearest.prim.tobytes():
                    wrong.append("something else is nearest")
            except Exception as error:  # a thread's exception would be lost
                wrong.append(error)

    threads = [threading.Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    fl.build(LINES[:1000])
    for thread in threads:
        thread.join()
    assert wrong == []


#: What is made before, and the call. Each would take far longer than a test may, but for calls of few rays, which are
#: watched if there is much to meet.
ENDLESS = {
    "build bvh-d2": ("many = lines(400_000)", "fl.build(many, 'bvh-d2', splits=fl.PlaneGrid(1000), progress=say)"),
    "build kd-d2": ("many = lines(100_000)", "fl.build(many, 'kd-d2', splits=fl.PlaneGrid(1000), progress=say)"),
    "build bvh-cl": ("many = lines(1_000_000)", "fl.build(many, 'bvh-cl', lookahead=4, progress=say)"),
    "build events, tight": ("many = lines(60_000)", "fl.build(many, splits=fl.PlaneEvents(), progress=say)"),
    "build events, lookahead 4": (
        "many = lines(60_000)",
        "fl.build(many, splits=fl.PlaneEvents(), lookahead=4, progress=say)",
    ),
    "build lookahead 8": ("many = lines(20_000)", "fl.build(many, lookahead=8, progress=say)"),
    "brute force": (
        "many, r = lines(200_000), rays(3_000_000)",
        "fl.brute_force(many, *r, 0.01, query='first_hit', progress=say)",
    ),
    "brute force, few rays": (
        "many, r = fl.Lines.from_segments(lines(3_000_000)), rays(255)",
        "fl.brute_force(many, *r, 0, query='count_hits', progress=say)",
    ),
    "tree of one leaf": (
        "r = rays(255); t = fl.build(lines(3_000_000), limits=fl.Limits(max_depth=0)); t.layout",
        "t.count_hits(*r, 10, progress=say)",
    ),
    "a group of rays": (
        "t = fl.build(lines(300_000), 'bvh-cl'); r = rays(64); t.layout",
        "t.all_hits(*r, 10, progress=say)",
    ),
    "all hits": ("t = fl.build(lines(20_000), 'bvh-cl'); r = rays(500_000)", "t.all_hits(*r, 0.05, progress=say)"),
    "nearest": ("t = fl.build(lines(20_000), 'bvh-cl'); p = rays(10_000_000)[0]", "t.nearest(p, progress=say)"),
    "within": ("t = fl.build(lines(20_000), 'bvh-cl'); p = rays(500_000)[0]", "t.within(p, 0.2, progress=say)"),
    "brute force of points": (
        "many, p = lines(200_000), rays(3_000_000)[0]",
        "fl.brute_force_points(many, p, progress=say)",
    ),
    "within of few points": (
        "p = rays(255)[0]; t = fl.build(lines(3_000_000), limits=fl.Limits(max_depth=0)); t.layout",
        "t.count_within(p, 10, progress=say)",
    ),
}


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
@pytest.mark.parametrize("what", few_of(ENDLESS, n=2))
def test_ctrl_c(what: str) -> None:
    """The call says when it is under way; then it is interrupted."""
    before, call = ENDLESS[what]
    program = f"""
import signal
import numpy as np, fastlines as fl

signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts in the background ignores it
shares = []

def say(share):
    shares.append(share)
    if len(shares) == 1:
        print("go", flush=True)

def lines(n):
    start = np.random.default_rng(0).uniform(-1, 1, (n, 1, 3)).astype(np.float32)
    return start + np.random.default_rng(1).normal(0, 0.2, (n, 2, 3)).astype(np.float32)

def rays(n):
    return np.random.default_rng(2).uniform(-1, 1, (2, n, 3)).astype(np.float32)

fl.set_num_threads(1)
{before}
try:
    {call}
except KeyboardInterrupt:
    print("stopped" if shares[-1] < 1 else "too late", flush=True)
else:
    print("ended", flush=True)
"""
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "go\n"
            process.send_signal(signal.SIGINT)
            said, _ = process.communicate(timeout=HANGS)
        finally:
            process.kill()
    assert said == "stopped\n"
    assert process.returncode == 0


@pytest.mark.parametrize("n_threads", [1, 3])
@pytest.mark.parametrize("where", few_of([0, 300_000, 799_999], n=1))
def test_a_ray_that_is_none_is_found_wherever_it_stands(where: int, n_threads: int) -> None:
    """Large batches are looked at in parts, by several threads."""
    n_rays = 800_000  # enough for three threads
    tree = fl.build(FEW[:1])
    good = {
        "origins": np.zeros((n_rays, 3), np.float32),
        "directions": np.ones((n_rays, 3), np.float32),
        "radius": np.full(n_rays, 0.1, np.float32),
        "t_min": np.zeros(n_rays, np.float32),
        "t_max": np.ones(n_rays, np.float32),
    }
    bad = {"origins": np.nan, "directions": 0, "radius": -1, "t_min": 2, "t_max": np.nan}
    fl.set_num_threads(n_threads)
    assert len(tree.first_hit(**good).skipped) == 0
    for name, value in bad.items():
        rays = {**good, name: good[name].copy()}
        rays[name][where] = value
        with pytest.raises(fl.InputError, match=rf"^1 of 800000 rays .*\(row {where}\)"):
            tree.any_hit(**rays)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "options"), [("spaghetti-2", {}), ("bun-hair", {}), ("bun-hair", {"presplit": fl.Presplit(refs=3)})]
)
def test_a_layout_is_the_same_whoever_makes_it(scene: str, options: dict[str, Any]) -> None:
    """Whole subtrees are laid out apart, by several threads; and by the module of each instruction set."""
    tree = fl.build(fl.scenes.make(scene).lines, "bvh-cl" if options else "best", **options)
    nodes, refs = tree.words()
    layout = tree.layout
    assert len(refs) > 2 << 14
    # Pieces that meet in a leaf are joined, and none is lost.
    assert (len(layout.refs) < len(refs)) == bool(options)
    first, last = layout.refs[:, 1] & 0xFFFF, layout.refs[:, 1] >> 16
    length = np.where(last == 0xFFFF, 0x10000, last) - first.astype(np.int64)
    assert (np.bincount(layout.refs[:, 0], length) == 0x10000).all()
    assert np.bincount(layout.refs[:, 0]).size == len(tree.geometry)
    try:
        for simd in fl.available_simd():
            for n_threads in (1, 2, 5):
                fl.set_simd(simd)
                fl.set_num_threads(n_threads)
                made = build_layout(tree.geometry, nodes, refs, tree.nodes["box"][0])
                for name in ("nodes", "leaves", "refs", "mean_extent"):
                    assert np.array_equal(getattr(layout, name), getattr(made, name)), (name, simd, n_threads)
    finally:
        fl.set_simd(None)


@pytest.mark.skipif(sys.platform != "linux", reason="needs a limit on memory")
@pytest.mark.parametrize("megabytes", few_of([60, 200, 400], n=1))
@pytest.mark.parametrize("call", ["tree.count_hits(*rays, 0.01).sum() == expected", "fl.build(many)"])
def test_threads_that_can_not_be_had_are_an_error_or_done_without(call: str, megabytes: int) -> None:
    """Each thread takes 8 MB of address space for its stack; a process may not have so much."""
    program = f"""
import resource
import numpy as np, fastlines as fl
many = np.random.default_rng(0).uniform(-1, 1, (10_000, 2, 3))
rays = np.random.default_rng(1).uniform(-1, 1, (2, 300_000, 3))
tree = fl.build(many[:100])
expected = tree.count_hits(*rays, 0.01).sum()
fl.set_num_threads(1024)
with open("/proc/self/statm") as file:
    used = int(file.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + ({megabytes} << 20),) * 2)
try:
    assert {call}
except (fl.FastlinesError, RuntimeError, MemoryError, OSError) as error:
    print(error)
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=HANGS, check=False)
    assert ended.returncode == 0, f"exit code {ended.returncode}: {ended.stderr[-1000:]}"
