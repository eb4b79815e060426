"""The compiled modules: none uses code of another."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fastlines as fl


@pytest.mark.skipif(not sys.platform.startswith("linux") or shutil.which("nm") is None, reason="needs nm")
def test_engines_export_nothing_else() -> None:
    """A function that two modules export could be called by one and be the other's."""
    modules = sorted(Path(fl.__file__).parent.glob("_engine_*.so"))
    assert len(modules) >= len(fl.available_simd())
    for module in modules:
        symbols = subprocess.run(["nm", "-D", "--defined-only", module], capture_output=True, text=True, check=True)
        exported = [line.split()[-1] for line in symbols.stdout.splitlines()]
        assert exported == [f"PyInit_{module.name.split('.')[0]}"]
