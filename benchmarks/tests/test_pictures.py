"""The command ``pictures`` at a tiny size."""

from __future__ import annotations

import json
import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused

import fastlines as fl
from fastlines_bench.harness.internals import FastlinesError
from fastlines_bench.studies.pictures.cases import GALLERY, dense_head
from fastlines_bench.studies.pictures.run import timed_process

pytestmark = pytest.mark.usefixtures("in_own_folder")
GUIDE = Path(__file__).parents[2] / "docs" / "gallery.md"


def test_run():
    np.save("own.npy", np.random.default_rng(0).random((20, 2, 3)))
    text = done(
        "pictures", "--quick", "--picture", "spaghetti,bear", "--file", "own.npy", "--peer", "none", "--json", "p.json"
    )
    assert "pictures with 2 thread(s)" in text
    assert "Left out, because their files are not there (--data names their folder): bear." in " ".join(text.split())
    result = json.loads(Path("p.json").read_text())
    assert result["format"] == "fastlines-bench pictures 1"
    assert [cell["name"] for cell in result["cells"]] == ["spaghetti", "own.npy"]
    assert result["missing"] == ["bear"]
    for cell in result["cells"]:
        assert 0 < cell["ours"]["first"] <= cell["ours"]["seconds"]
        assert cell["ours"]["cpu"] > 0
        assert (cell["peer"], cell["why"]) == (None, "not asked for")


def test_the_pictures_are_those_of_the_gallery():
    commands = re.findall(r"^fastlines render (\S+) (.*?)-o \S+$", GUIDE.read_text(encoding="utf-8"), re.MULTILINE)
    assert {(source, *shlex.split(options)) for source, options in commands} == set(GALLERY.values())


def test_a_dense_head_is_a_case(tmp_path):
    case = dense_head(tmp_path, None, 300, 16, 2)
    assert case.is_there
    assert fl.load(case.source).geometry.n_strands == 300
    assert case.options[:6] == ("--look", "hair", "--quality", "high", "--samples", "2")


def test_a_command_that_fails_says_why(tmp_path):
    picture = tmp_path / "x.png"
    with pytest.raises(FastlinesError, match="no such file"):
        timed_process([sys.executable, "-m", "fastlines", "render", "no.tfx", "-o", str(picture)], picture, 1)


def test_refused():
    assert ".json" in refused("pictures", "--json", "p.txt")[1]
    assert "is not a picture of the gallery" in refused("pictures", "--picture", "mona-lisa")[1]
    assert "is not a folder" in refused("pictures", "--data", "nowhere")[1]
    assert "there is no such file" in refused("pictures", "--file", "no.tfx")[1]
    assert "is not a peer" in refused("pictures", "--peer", "mitsuba")[1]
