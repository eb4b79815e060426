"""Helpers that call the command line in tests."""

from __future__ import annotations

import os
import re

from typer.testing import CliRunner

from fastlines_bench.cli import app


def run(*args):
    return CliRunner().invoke(app, [str(arg) for arg in args])


def done(*args):
    """Run a command that must succeed; return its output."""
    result = run(*args)
    assert (result.exit_code, result.stderr) == (0, "")
    return result.stdout


def refused(*args):
    """Run a command that must fail; return its exit code and its error message."""
    result = run(*args)
    assert result.exit_code not in (0, 70), result.output
    assert result.stdout == ""
    assert re.fullmatch(r"error: [^\n]+\n", result.stderr), result.stderr
    assert not [entry for entry in os.scandir(".") if entry.name.endswith(".partial")]
    return result.exit_code, result.stderr
