"""A host that emulates a GPU, for all tests of this folder."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from support.emulated_device import EmulatedDevice, require_compiler

from fastlines.cuda.choice import use_device


@pytest.fixture(scope="session")
def emulated(tmp_path_factory: pytest.TempPathFactory) -> EmulatedDevice:
    require_compiler()
    return EmulatedDevice(tmp_path_factory.mktemp("emulated"))


@pytest.fixture
def device(emulated: EmulatedDevice) -> Iterator[EmulatedDevice]:
    """Put the host in the place of the GPU."""
    emulated.launched.clear()
    emulated.uploaded.clear()
    with use_device(emulated):
        yield emulated
