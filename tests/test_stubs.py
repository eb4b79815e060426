"""The stubs of the compiled modules are what nanobind's stubgen makes of them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


def test_stubs_are_those_of_the_modules() -> None:
    pytest.importorskip("nanobind.stubgen")
    script = Path(__file__).parents[1] / ".ci" / "stubs"
    done = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
