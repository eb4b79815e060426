"""Fixtures of several test files."""

from __future__ import annotations

import pytest

# Rewrite the assertions of this helper, too, so that pytest explains them.
pytest.register_assert_rewrite("command_line")


@pytest.fixture
def in_own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("FASTLINES_DEBUG", raising=False)


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    """Keep tuned lengths out of the user's cache."""
    from fastlines_bench.peers import tuning

    path = tmp_path / "cache" / "tuning.json"
    monkeypatch.setattr(tuning, "cache_file", lambda: path)
    return path
