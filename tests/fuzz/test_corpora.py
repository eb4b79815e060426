"""Each file of the corpora once more, through the functions that the fuzzer calls: what was found stays found."""

from __future__ import annotations

import tracemalloc
from importlib.util import find_spec
from pathlib import Path

import pytest
import targets
from mutators import joined_tree, split_tree

from fastlines.io import table

CORPORA = Path(__file__).parent / "corpora"
FILES = [path for target in targets.TARGETS for path in sorted((CORPORA / target.name).glob("*"))]
#: A small file takes no more memory than so many bytes.
MAX_BYTES = 30 << 20


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
@pytest.mark.parametrize("path", FILES, ids=[f"{path.parent.name}/{path.name}" for path in FILES])
def test_file(path: Path) -> None:
    target = targets.by_name(path.parent.name)
    if missing := [name for name in target.needs if find_spec(name) is None]:
        pytest.skip(f"needs {', '.join(missing)}")
    tracemalloc.start()
    try:
        is_accepted = targets.check(target, path.read_bytes())
        assert tracemalloc.get_traced_memory()[1] < MAX_BYTES
    finally:
        tracemalloc.stop()
    assert is_accepted or not path.name.startswith("seed-")


def test_each_format_has_a_target() -> None:
    readers = [target for target in targets.TARGETS if target.name not in ("wkb", "load")]
    fuzzed = {table.named(target.extension).name for target in readers}
    rows = {row.name for row in map(table.named, table.known_formats()) if row.module is None}
    assert fuzzed | targets.LEFT_OUT.keys() == rows
    assert not fuzzed & targets.LEFT_OUT.keys()


def test_each_target_has_a_corpus() -> None:
    assert {path.parent.name for path in FILES} == {target.name for target in targets.TARGETS}


def test_seeds_are_those_of_their_builders() -> None:
    for target in targets.TARGETS:
        if target.name not in ("npz", "load"):  # whose bytes depend on the version of NumPy, or of the package
            for i, data in enumerate(target.seeds()):
                assert (CORPORA / target.name / f"seed-{i}.{target.extension}").read_bytes() == data, target.name


def test_trees_that_are_put_together_have_right_checksums() -> None:
    tree = targets.by_name("load")
    for data in tree.seeds():
        assert tree.run(joined_tree(*split_tree(data)), 0, False)
