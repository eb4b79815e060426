"""Where the library for C++ and C programs is installed."""

from __future__ import annotations

from pathlib import Path

from ..errors import FastlinesError

#: The folders of the library, in the folder of the package.
_PACKAGE = Path(__file__).resolve().parents[1]


def get_include() -> str:
    """Return the folder to pass to a compiler by ``-I``: it holds ``fastlines/fastlines.hpp`` and ``fastlines.h``.

    Raises
    ------
    FastlinesError
        If this installation has no library, as one from a source folder.

    Examples
    --------
    >>> import fastlines as fl
    >>> fl.get_include().endswith("include")
    True
    """
    return _folder("include")


def get_lib() -> str:
    """Return the folder of the compiled library, to pass to a linker by ``-L``."""
    return _folder("lib")


def get_cmake_dir() -> str:
    """Return the folder of the CMake package, for ``fastlines_DIR`` or ``CMAKE_PREFIX_PATH``."""
    return _folder("lib/cmake/fastlines")


def compiler_flags() -> str:
    """Return the flags that compile a program in C, or in C++20 or later, with a compiler that takes those of GCC."""
    return f"-I{get_include()}"


def linker_flags() -> str:
    """Return what links a program with the static library, for a compiler that takes the flags of GCC."""
    return f"{get_lib()}/libfastlines.a -pthread"


def _folder(name: str) -> str:
    folder = _PACKAGE / name
    if not folder.is_dir():
        raise FastlinesError(
            f"this installation has no library for C++ programs: there is no folder {folder}; install the package "
            "with pip install ., or the library with cmake --install"
        )
    return str(folder)
