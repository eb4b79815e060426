"""Which Python files are mutated, and the import of them with their mutants."""

from __future__ import annotations

import ast
import importlib.machinery
import importlib.util
import sys
from collections.abc import Sequence
from dataclasses import replace
from importlib.abc import MetaPathFinder
from pathlib import Path
from types import CodeType, ModuleType

from .mutant import Mutant, tell_apart
from .python_schemata import SWITCH, numeric_limits, schemata

#: Files that check and limit, as patterns below the package: all of their functions are mutated.
CHECKS = (
    "arrays.py",
    "io/packed_source.py",
    "io/source.py",
    "settings/settings.py",
    "settings/splits.py",
    "structure/*.py",
    "support/container.py",
)
#: Other files: only their functions that refuse something are mutated.
REFUSALS = ("query/**/*.py", "geometry/*.py", "io/*.py", "io/formats/*.py")
#: Constants that say how much is done at once. Others give the same answers.
AT_ONCE = (
    {"AT_ONCE", "BLOCK", "COUNTED_RAYS", "FIRST_SHARE", "FULL", "MORE", "PART", "PIECE"}
    | {"_BATCH", "_BLOCK", "_FIRST_BYTES", "_N_END", "_STEP"}
)  # fmt: skip


class MutatedSources:
    """The files with their mutants, in the order of their paths; the numbers of the mutants are the same each time."""

    def __init__(self, package: Path) -> None:
        checks = {path for pattern in CHECKS for path in package.glob(pattern)}
        paths = sorted(checks | {path for pattern in REFUSALS for path in package.glob(pattern)})
        texts = {path: path.read_text(encoding="utf-8") for path in paths}
        trees = {path: ast.parse(text) for path, text in texts.items()}
        own = {path: numeric_limits(tree) for path, tree in trees.items()}
        shared = {name: kind for of in own.values() for name, kind in of.items() if not name.startswith("_")}
        self.mutants: list[Mutant] = []
        for path, tree in trees.items():
            imported = {alias.name for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names}
            limits = {name: shared[name] for name in imported & shared.keys()} | own[path]
            limits = {name: kind for name, kind in limits.items() if name not in AT_ONCE}
            file, first = path.relative_to(package).as_posix(), len(self.mutants) + 1
            found = schemata(tree, file, first, limits, refusals_only=path not in checks)
            lines = texts[path].splitlines()
            # A function has many a number 1; its line tells which.
            self.mutants += [replace(each, place=f"{each.place}: {lines[each.line - 1].strip()}") for each in found]
        tell_apart(self.mutants)
        self._trees = {str(path): tree for path, tree in trees.items()}

    def install(self, switch: ModuleType) -> None:
        """Let imports from now on find the mutated modules, which ask a module for the switch."""
        loaded = [name for name in sys.modules if name.split(".")[0] == "fastlines"]
        if loaded:
            raise RuntimeError(f"{loaded[0]} is imported already, without its mutants")
        sys.meta_path.insert(0, _Finder(self._trees, switch))


def package_folder() -> Path:
    """Return the folder of the installed package, without importing it."""
    spec = importlib.util.find_spec("fastlines")
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("fastlines is not installed")
    return Path(spec.origin).parent


class _Finder(MetaPathFinder):
    """Finds the mutated modules where Python finds the real ones."""

    def __init__(self, trees: dict[str, ast.Module], switch: ModuleType) -> None:
        self._trees, self._switch = trees, switch

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if not fullname.startswith("fastlines."):
            return None
        spec = importlib.machinery.PathFinder.find_spec(fullname, path, target)
        if spec is None or spec.origin not in self._trees:
            return None
        spec.loader = _Loader(fullname, spec.origin, self._trees[spec.origin], self._switch)
        return spec


class _Loader(importlib.machinery.SourceFileLoader):
    """Compiles a mutated tree, and gives the module the switch."""

    def __init__(self, fullname: str, path: str, tree: ast.Module, switch: ModuleType) -> None:
        super().__init__(fullname, path)
        self._tree, self._switch = tree, switch

    def get_code(self, fullname: str) -> CodeType:
        code: CodeType = compile(self._tree, self.path, "exec", dont_inherit=True)
        return code

    def exec_module(self, module: ModuleType) -> None:
        setattr(module, SWITCH, self._switch)
        super().exec_module(module)
