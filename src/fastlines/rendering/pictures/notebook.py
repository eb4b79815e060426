"""Pictures in the cells of notebooks: one that takes long is shown while it is made, and replaced by better ones."""

from __future__ import annotations

import sys
import weakref
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

#: The picture that was shown last while it was made, and the cell that shows it.
_last: tuple[weakref.ref[Any], object] | None = None


@dataclass
class Cell:
    """The cell of a notebook that runs.

    Attributes
    ----------
    shell : InteractiveShell
        That of IPython.
    """

    shell: Any
    _display: Any = field(default=None, init=False)

    def show(self, picture: Any) -> None:
        """Show a picture in the place of the last one."""
        ipython = import_module("IPython.display")
        shown = ipython.Image(data=picture._repr_png_(), format="png")
        if self._display is None:
            self._display = ipython.display(shown, display_id=True)
        else:
            self._display.update(shown)

    def end(self, picture: Any) -> None:
        """Show the whole picture. If it is also the value of the cell, it is not shown a second time."""
        global _last
        self.show(picture)
        _last = weakref.ref(picture), self.shell.execution_count


def cell_of_notebook() -> Cell | None:
    """Return the cell that runs, if this is a notebook: a kernel of IPython, rather than a terminal or a script."""
    shell = _shell()
    return None if shell is None or not hasattr(shell, "kernel") else Cell(shell)


def is_in_cell(picture: Any) -> bool:
    """Return whether the cell that runs has shown a picture while it was made."""
    shell = _shell()
    return _last is not None and shell is not None and _last[0]() is picture and _last[1] == shell.execution_count


def _shell() -> Any:
    """Return the shell of IPython; None outside of it."""
    module = sys.modules.get("IPython")
    return None if module is None else module.get_ipython()
