"""Former names work for one more release, with a warning; files of earlier versions load."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines import container

ENDS = [[[0, 0, 0], [1, 1, 1]], [[0, 1, 0], [1, 0, 1]]]


def test_former_classes_warn_and_make_the_new_ones() -> None:
    with pytest.warns(DeprecationWarning, match="fl.PlaneOctets is now fl.BinnedPlanes"):
        made = fl.PlaneOctets(8, max_whole=64, only_whole=16, max_overlap=0.5, sample=9, max_apart=100, apart=0.7)
    assert made == fl.BinnedPlanes(8, 64, 16, 0.5, 9, 100, 0.7)
    with pytest.warns(DeprecationWarning, match="fl.Middle is now fl.Midpoint"):
        assert fl.Middle() == fl.Midpoint()
    with pytest.warns(DeprecationWarning, match="fl.RebuildRule is now fl.RebuildPolicy"):
        assert isinstance(fl.RebuildRule(build_seconds=1.0), fl.RebuildPolicy)


def test_a_former_module_is_the_new_one() -> None:
    from fastlines import analytic

    assert fl.analytic is analytic
    assert analytic.closest_approach is fl.theory.hits.closest_approach


def test_the_former_depth_picture_is_the_look_depth() -> None:
    with pytest.warns(DeprecationWarning, match=r'depth_picture is now fl.render\(tree, camera, look="depth"\)'):
        from fastlines.rendering import depth_picture
    tree, camera = fl.build(ENDS), fl.Camera((0, 0, 5), (0.5, 0.5, 0))
    picture = depth_picture(tree, camera, 30, 20, 0.1)
    assert (picture.shape, picture.dtype, picture.max()) == ((20, 30), np.uint8, 255)
    shown = fl.render(tree, camera, width=30, height=20, radius=0.1, look="depth", samples=9).to_bytes()[..., 0]
    assert ((picture > 0) == (shown > 0)).all()
    with pytest.raises(ImportError, match="depth_pictures"):
        from fastlines.rendering import depth_pictures  # noqa: F401


def test_a_name_that_never_was() -> None:
    with pytest.raises(AttributeError, match="no attribute 'octrees'"):
        fl.octrees  # noqa: B018


def test_dir_lists_the_public_names() -> None:
    assert {name for name in dir(fl) if not name.startswith("__")} == set(fl.__all__)
    assert {"__version__", "__doc__"} <= set(dir(fl))


@pytest.mark.parametrize(
    ("former", "now"),
    [
        (
            {
                "name": "plane_octets",
                "max_refs": None,
                "min_overlap": 0.0,
                "n_planes": 8,
                "max_whole": 64,
                "only_whole": 16,
                "max_overlap": 0.5,
                "sample": 0,
                "max_apart": 100,
                "apart": 0.7,
            },
            fl.BinnedPlanes(8, 64, 16, 0.5, gap_refs=100, gap=0.7),
        ),
        ({"name": "middle", "max_refs": 9, "min_overlap": 0.0}, fl.Midpoint(max_refs=9)),
    ],
)
def test_files_of_earlier_versions(tmp_path: Path, former: dict[str, Any], now: fl.splits.SplitSet) -> None:
    path = tmp_path / "a.flt"
    tree = fl.build(ENDS, splits=now)
    tree.save(path)
    assert fl.load(path).settings == tree.settings
    arrays, metadata = container.read(path)
    settings = json.loads(metadata["settings"]) | {"splits": [former]}
    container.write(path, arrays, {**metadata, "settings": json.dumps(settings)})
    assert fl.load(path).settings == tree.settings
