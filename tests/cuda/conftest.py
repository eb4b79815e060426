"""A host that plays a GPU, for all tests of this folder."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from support.played_device import PlayedDevice, require_compiler

from fastlines.cuda.choice import use_device


@pytest.fixture(scope="session")
def played(tmp_path_factory: pytest.TempPathFactory) -> PlayedDevice:
    require_compiler()
    return PlayedDevice(tmp_path_factory.mktemp("played"))


@pytest.fixture
def device(played: PlayedDevice) -> Iterator[PlayedDevice]:
    """Put the host in the place of the GPU."""
    played.launched.clear()
    played.uploaded.clear()
    with use_device(played):
        yield played
