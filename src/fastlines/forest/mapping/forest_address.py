"""Where a forest is, as tasks name it; each process keeps the forests open that its tasks have queried."""

from __future__ import annotations

import os
import threading
from collections import OrderedDict
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...errors import FileFormatError

if TYPE_CHECKING:
    from ..forest import Forest

#: How many forests a process keeps open.
MOST_OPEN = 4

_open: OrderedDict[ForestAddress, Forest] = OrderedDict()
_lock = threading.Lock()


@dataclass(frozen=True)
class ForestAddress:
    """The path of a forest, and what identifies its content."""

    kind: type[Forest]
    path: str
    #: That of the manifest.
    digest: str
    memory: int | None = None
    verify: bool | None = None
    #: Whether rays and points are less the offset of the lines.
    less_offset: bool = False

    @classmethod
    def of(cls, forest: Forest) -> ForestAddress:
        """Return the address of a forest, which stays open in this process."""
        store = forest._store
        content = os.path.abspath(forest.path), forest.manifest.digest
        made = cls(type(forest), *content, store.memory, store.verify, forest._less_offset)
        _keep(made, forest._here())
        return made

    def opened(self) -> Forest:
        """Return the forest; open it if this process has not.

        Raises
        ------
        FileFormatError
            If this process sees another forest at the path, or none.
        """
        with _lock:
            found = _open.get(self)
        if found is None:
            found = self._read()
            _keep(self, found)
        return found

    def _read(self) -> Forest:
        try:
            forest = self.kind(self.path, memory=self.memory, verify=self.verify)
        except (FileNotFoundError, NotADirectoryError):
            raise FileFormatError(
                f"does not see {self.path}; workers need the files of a forest at the path where the caller has "
                "opened it, as on a shared disk"
            ) from None
        if forest.manifest.digest != self.digest:
            raise FileFormatError(
                f"sees another forest at {self.path} than the caller has opened; if it has been built again since, "
                "open it again, else give both the same files there"
            )
        return forest.without_offset() if self.less_offset else forest


def _keep(address: ForestAddress, forest: Forest) -> None:
    """Keep a forest open, and let go of the one that was opened first."""
    with _lock:
        _open[address] = forest
        _open.move_to_end(address)
        while len(_open) > MOST_OPEN:
            _open.popitem(last=False)
