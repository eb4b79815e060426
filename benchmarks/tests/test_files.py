"""The command ``files`` at a tiny size."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import done, refused

from fastlines_bench.studies import file_reader
from fastlines_bench.studies.files import streamlines

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_run():
    text = done("files", "--quick", "--segments", 2000, "--format", ".trk,.tck,.trx", "--json", "f.json")
    for said in ("reading 2,000 segments", "fastlines", ".trk", ".tck", ".trx"):
        assert said in text
    result = json.loads(Path("f.json").read_text())
    assert result["format"] == "fastlines-bench files 1"
    assert {cell["extension"] for cell in result["cells"]} == {".trk", ".tck", ".trx"}
    for cell in result["cells"]:
        assert cell["reader"] in file_reader.READERS
        assert cell["seconds"] > 0
        assert cell["bytes"] >= 0


def test_streamlines():
    for n, per_strand in ((1, 1), (10, 50), (1000, 6)):
        lines = streamlines(n, per_strand)
        assert n <= len(lines) <= 2 * n + 75
        assert lines.n_strands == max(1, n // per_strand)


def test_refused():
    assert ".json" in refused("files", "--json", "f.txt")[1]
    assert "is not a format" in refused("files", "--format", ".png")[1]
