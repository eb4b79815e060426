"""The messages that docs/faq.md quotes as text, because its code cannot provoke them on each machine, are ours."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines import engines
from fastlines.cuda import cuda_device
from fastlines.query import memory_check

PAGE = (Path(__file__).parents[1] / "docs" / "faq.md").read_text(encoding="utf-8")
QUOTED = [" ".join(text.split()) for text in re.findall(r"```text\n(.*?)```", PAGE, re.DOTALL)]


def too_many_hits(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr(memory_check, "left_memory", lambda: 1e9)
    tree = fl.build(np.tile(np.array([[[-1, 0, 0], [1, 0, 0]]], np.float32), (100, 1, 1)))
    return tree.all_hits(np.zeros((3_000_000, 3), np.float32), [0, 0, 1], radius=1)


def another_processor(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr(engines, "available_simd", tuple)
    monkeypatch.setattr(engines, "compiled_simd", lambda: ("avx512",))
    monkeypatch.setattr(engines, "_core", SimpleNamespace(best_simd=lambda: "avx2"))
    monkeypatch.setattr(engines, "_forced", None)
    monkeypatch.delenv("FASTLINES_SIMD", raising=False)
    return fl.simd()


def no_gpu(monkeypatch: pytest.MonkeyPatch) -> Any:
    def no_device() -> Any:
        raise RuntimeError("no driver")

    monkeypatch.setattr(cuda_device, "optional", lambda *_: SimpleNamespace(Device=no_device))
    return fl.set_backend("cuda")


@pytest.mark.parametrize("provoke", [too_many_hits, another_processor, no_gpu], ids=lambda provoke: provoke.__name__)
def test_quoted_messages(provoke: Callable[[pytest.MonkeyPatch], Any], monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises((fl.FastlinesError, MemoryError)) as caught:
        provoke(monkeypatch)
    patterns = [re.escape(quoted).replace("…", ".+") for quoted in QUOTED]
    assert sum(re.fullmatch(pattern, str(caught.value)) is not None for pattern in patterns) == 1, str(caught.value)
