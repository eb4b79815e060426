"""Properties that one thread computes: objects do not wait for each other."""

from __future__ import annotations

import copy
import csv
import os
import pickle
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.patience import HANGS

import fastlines as fl
import fastlines.cuda.placed_tree
from fastlines.io.formats import wkt
from fastlines.support.computed_once import _locks, computed_once

SEGMENTS = np.random.default_rng(0).random((50, 2, 3)).astype(np.float32)


@dataclass(frozen=True)
class Slow:
    name: str
    entered: Any = None
    may_end: Any = None

    @computed_once
    def value(self) -> list[str]:
        if self.entered is not None:
            self.entered.set()
            assert self.may_end.wait(HANGS)
        return [self.name]

    @computed_once
    def other(self) -> int:
        return len(self.value)

    @computed_once
    def wrong(self) -> int:
        raise ValueError(self.name)


def test_an_object_does_not_wait_for_another() -> None:
    slow = Slow("slow", threading.Event(), threading.Event())
    with ThreadPoolExecutor() as pool:
        first = pool.submit(lambda: slow.value)
        assert slow.entered.wait(HANGS)
        assert Slow("quick").value == ["quick"]
        second = pool.submit(lambda: slow.value)
        slow.may_end.set()
        assert first.result() is second.result() is slow.value
    assert not _locks


def test_a_query_does_not_wait_for_the_layout_of_another_tree(monkeypatch: pytest.MonkeyPatch) -> None:
    entered, may_end = threading.Event(), threading.Event()
    large, small = fl.build(SEGMENTS), fl.build(SEGMENTS[:5])
    build_layout = fastlines.cuda.placed_tree.build_layout

    def build(geometry: Any, *arguments: Any, **how: Any) -> Any:
        if geometry is large.geometry:
            entered.set()
            assert may_end.wait(HANGS)
        return build_layout(geometry, *arguments, **how)

    monkeypatch.setattr(fastlines.cuda.placed_tree, "build_layout", build)
    with ThreadPoolExecutor() as pool:
        laid_out = pool.submit(lambda: large.layout)
        assert entered.wait(HANGS)
        assert small.count_hits(SEGMENTS[:5, 0], [0, 0, 1], 0.1).all()
        may_end.set()
        assert laid_out.result() is large.layout


@pytest.mark.skipif(not hasattr(os, "fork"), reason="fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_fork_does_not_wait_for_threads_that_it_does_not_have() -> None:
    slow = Slow("slow", threading.Event(), threading.Event())
    with ThreadPoolExecutor() as pool:
        first = pool.submit(lambda: slow.value)
        assert slow.entered.wait(HANGS)
        if not (child := os.fork()):
            slow.may_end.set()
            os._exit(slow.value != ["slow"])
        try:
            for _ in range(100):
                done, status = os.waitpid(child, os.WNOHANG)
                if done:
                    break
                time.sleep(HANGS / 1e4)
            else:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
                pytest.fail("the fork waits")
        finally:
            slow.may_end.set()
        assert os.waitstatus_to_exitcode(status) == 0
        assert first.result() == ["slow"]


def test_one_property_may_ask_for_another_and_errors_are_not_kept() -> None:
    one = Slow("one")
    assert one.other == 1
    for _ in range(2):
        with pytest.raises(ValueError, match="one"):
            _ = one.wrong
    assert set(one.__dict__) == {"name", "entered", "may_end", "other", "value"}
    assert not _locks


def test_copies_and_pickles() -> None:
    one = Slow("one")
    assert one.value == ["one"]
    for made in (copy.copy(one), copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
        assert made.value == ["one"]
    assert isinstance(Slow.value, computed_once)


def test_no_property_has_a_lock_for_all_objects() -> None:
    """`functools.cached_property` has one in Python 3.11."""
    package = Path(fl.__file__).parent
    users = [path for path in package.rglob("*.py") if "import cached_property" in path.read_text(encoding="utf-8")]
    assert users == [package / "support" / "computed_once.py"]


def test_tables_are_read_at_the_same_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """While one is read, another with a field longer than the csv module's own limit is read, too."""
    before = csv.field_size_limit()
    row = '"LINESTRING (' + ", ".join(f"{i} 0" for i in range(40_000)) + ')"\n'
    assert len(row) > before
    for name in ("slow.csv", "quick.csv"):
        (tmp_path / name).write_text(f"wkt\n{row}")
    entered, may_end = threading.Event(), threading.Event()
    rows = wkt._rows

    def read(source: Any, *arguments: Any) -> Any:
        if "slow" in str(source.path):
            entered.set()
            assert may_end.wait(HANGS)
        return rows(source, *arguments)

    monkeypatch.setattr(wkt, "_rows", read)
    with ThreadPoolExecutor() as pool:
        slow = pool.submit(fl.read, tmp_path / "slow.csv")
        assert entered.wait(HANGS)
        assert len(fl.read(tmp_path / "quick.csv")) == 39_999
        assert csv.field_size_limit() > before
        may_end.set()
        assert len(slow.result()) == 39_999
    assert csv.field_size_limit() == before
