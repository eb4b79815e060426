"""What a file format is: one row of the table of formats."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType
from typing import Any, Literal, get_args

from ..arrays import did_you_mean
from ..errors import InputError
from ..geometry.collection import Geometry
from ..geometry.curves import Curves
from ..geometry.lines import Lines

#: What a file of lines holds.
AnyLines = Lines | Curves | Geometry


@dataclass(frozen=True)
class Format:
    """A file format, and the module that reads and writes it.

    Attributes
    ----------
    name : str
        What ``format=`` calls it.
    extensions : tuple of str
        In lower case and with the dot. The first is the usual one.
    description : str
        Half a line.
    magic : tuple of bytes
        What each file of the format may begin with, if nothing else begins so.
    writes : tuple of type
        What ``write`` takes: `Lines`, `Curves` and `Geometry`. What it does not take is converted first.
    strands : {"polylines", "kept", "none"}
        What becomes of strands when lines are written: they are the polylines that follow one another in the file; or
        they are kept as they are; or files hold none.
    metadata : {"kept"} or tuple of str
        The metadata of lines that are written: all of them, or those of some names.
    up : {"x", "y", "z"}, optional
        The axis that points upwards by the format's convention.
    unit : str, optional
        The unit of length by the format's convention, such as ``"mm"``.
    text : bool
        Whether its files are text, or text with binary data behind it: the reader gets UTF-8 where they are UTF-16.
    folder : str, optional
        The name or the pattern, such as ``"*.parquet"``, of a file by which a folder is recognised as a file of the
        format. By default, no folder is one.
    module : str, optional
        The full name of the module that reads and writes; by default, that of the format's name in
        `fastlines.io.formats`. It has ``read(source, invalid, **options)``, which returns lines, curves or a `Geometry`
        of several. If files are written, it has ``write(geometry, path, **options)``, which returns what the format
        could not hold, as short texts. If files are read in chunks, it has ``read_chunks(source, max_segments, invalid,
        **options)``, which returns an iterator of `Lines`, or None if a file can only be read whole. Options are
        keyword-only parameters.

    Raises
    ------
    InputError
        If a name of the format or an extension cannot be used.
    """

    name: str
    extensions: tuple[str, ...]
    description: str
    magic: tuple[bytes, ...] = ()
    writes: tuple[type[Any], ...] = ()
    strands: Literal["polylines", "kept", "none"] = "polylines"
    metadata: Literal["kept"] | tuple[str, ...] = ()
    up: str | None = None
    unit: str | None = None
    text: bool = False
    folder: str | None = None
    module: str | None = None

    def __post_init__(self) -> None:
        if not re.fullmatch("[a-z0-9_-]+", self.name):
            raise InputError(f"the name of a format is {self.name!r}; expected lower-case letters and digits")
        for extension in self.extensions:
            if not re.fullmatch(r"\.[^A-Z.\s]+", extension) or extension in (".gz", ".flt"):
                raise InputError(
                    f"the format {self.name!r} has the extension {extension!r}; expected one such as '.xyz', in lower "
                    "case, other than .gz and .flt"
                )

    @property
    def code(self) -> ModuleType:
        """The module, imported on first use."""
        return import_module(self.module or f"{__package__}.formats.{self.name}")

    def options(self, of: Literal["read", "write"] = "read") -> dict[str, type[Any]]:
        """Return the options of its reader or writer, and the type of each: str, bool, int or float; else str."""
        parameters = inspect.signature(getattr(self.code, of), eval_str=True).parameters.values()
        named = (option for option in parameters if option.kind is inspect.Parameter.KEYWORD_ONLY)
        types = {option.name: (get_args(option.annotation) or (option.annotation,))[0] for option in named}
        return {name: kind if kind in (str, bool, int, float) else str for name, kind in types.items()}

    def check_options(self, path: str, options: Iterable[str], of: Literal["read", "write"] = "read") -> None:
        """Refuse options that the reader or the writer does not have."""
        known = self.options(of)
        for name in options:
            if name not in known:
                what = " of its writer" if of == "write" else ""
                has = did_you_mean(name, known) if known else "; it has no options"
                raise InputError(f"{path}: the format {self.name!r} has no option {name!r}{what}{has}")

    @property
    def write(self) -> Callable[..., list[str]]:
        """The writer."""
        writer: Callable[..., list[str]] = self.code.write
        return writer
