"""The mutated copy of a checkout, compiled once: the Python modules, and programs of the C++ tests."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from fastlines import InputError

from .cpp_mutants import CORE, Found, mutated

#: The C++ tests that run beside those in Python: those of parts that Python does not call by themselves.
PROGRAMS = (
    "collapse_plan",
    "cut",
    "leaf_cull",
    "point_cull",
    "ray_bundle",
    "retraced_lines",
    "round_cones",
    "scene_cull",
    "visited_set",
)
HEADER = Path(__file__).with_name("mutants.hpp")
_COPIED = ("cpp", "src", "examples", "CMakeLists.txt", "pyproject.toml")

Progress = Callable[[str, float], None]


class Build:
    """A folder with the mutated copy in `source` and what is compiled in `build`.

    Parameters
    ----------
    checkout : Path
        The repository.
    folder : Path
        Where the copy is made. A copy from before is brought up to date, and compiled only as far as it has changed.
    """

    def __init__(self, checkout: Path, folder: Path) -> None:
        self.checkout, self.folder = checkout, folder
        self.source, self.build = folder / "source", folder / "build"
        notes = folder / "notes.json"
        self._notes: dict[str, Any] = json.loads(notes.read_text()) if notes.exists() else {}
        self.left_out: set[tuple[str | int, ...]] = {tuple(key) for key in self._notes.get("left_out", [])}
        self.programs: list[Path] = []
        self.numbers: list[int] = []

    def make(self, found: Sequence[Found], progress: Progress) -> list[Found]:
        """Write and compile the copy; return the mutants in it, without those that do not compile."""
        self._check_tools()
        for name in _COPIED:
            _copy_changed(self.checkout / name, self.source / name, {each.file for each in found}, self.checkout)
        kept = self._write(found)
        progress("configure", 0.0)
        self._configure()
        # The modules instantiate nearly all code. If a program does not compile after all, check the programs too.
        if not self._compiled_before(kept):
            kept = self._check(found, self._targets()[:2], progress)
        progress("compile", 0.0)
        if self._compile():
            kept = self._check(found, self._targets()[2:], progress)
            progress("compile", 0.0)
            if errors := self._compile():
                raise InputError(f"the mutated copy does not compile:\n{errors}")
        self._note(compiled=self._digest(kept))
        self.numbers = [each.mutant.number for each in kept]
        return kept

    def _note(self, **values: Any) -> None:
        """Keep values for the next run in this folder."""
        self._notes.update(values)
        (self.folder / "notes.json").write_text(json.dumps(self._notes))

    def _digest(self, kept: Sequence[Found]) -> str:
        """Return a digest of the mutants and of the sources of the core."""
        sources = sorted(
            path.read_bytes() for path in (self.source / "cpp").rglob("*.?pp") if "tests" not in path.parts
        )
        return hashlib.sha256(repr([each.mutant.key for each in kept]).encode() + b"".join(sources)).hexdigest()

    def _compiled_before(self, kept: Sequence[Found]) -> bool:
        return self._notes.get("compiled") == self._digest(kept)

    def _check(self, found: Sequence[Found], targets: Sequence[str], progress: Progress) -> list[Found]:
        """Leave out the mutants that do not compile; return the others."""
        kept, commands = self._write(found), self._commands(targets)
        for i, command in enumerate(commands):
            progress(f"syntax of {Path(command['file']).name}", i / len(commands))
            while wrong := self._errors(command):
                bad = {each.mutant.key for each in kept if _lines(each) & wrong}
                if not bad:
                    places = ", ".join(f"{file}:{line}" for file, line in sorted(wrong))
                    raise InputError(f"the mutated copy in {self.source} does not compile: {places}")
                self.left_out |= bad
                self._note(left_out=sorted(self.left_out))
                kept = self._write(found)
        return kept

    def environment(self) -> dict[str, str]:
        """Return the environment of processes that use the compiled modules."""
        paths = [str(self.source / "src"), *filter(None, [os.environ.get("PYTHONPATH")])]
        return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}

    def _check_tools(self) -> None:
        missing = [name for name in ("cmake", "ninja") if shutil.which(name) is None]
        missing += [name for name in ("nanobind", "pytest", "hypothesis") if importlib.util.find_spec(name) is None]
        if missing:
            raise InputError(f"{', '.join(missing)}: not installed; pip install './benchmarks[mutation]'")

    def _write(self, found: Sequence[Found]) -> list[Found]:
        """Write the mutated files; return the mutants that they have."""
        kept = []
        for file in dict.fromkeys(each.file for each in found):
            of_file = [e for e in found if e.file == file and e.mutant.key not in self.left_out]
            text, written = mutated((self.checkout / file).read_text(encoding="utf-8"), of_file)
            kept += [each for each in of_file if each.mutant.number in written]
            _write_changed(self.source / file, text.encode())
        return kept

    def _configure(self) -> None:
        nanobind = subprocess.run([sys.executable, "-m", "nanobind", "--cmake_dir"], capture_output=True, text=True)
        defined = {
            "CMAKE_BUILD_TYPE": "Mutation",
            "CMAKE_CXX_FLAGS": f"-O1 -w -include {HEADER}",
            "CMAKE_EXPORT_COMPILE_COMMANDS": "ON",
            "CMAKE_SKIP_INSTALL_RULES": "ON",
            "FASTLINES_TESTS": "ON",
            "FASTLINES_DEVICE_VARIANTS": "OFF",
            "SKBUILD": "ON",
            "Python_EXECUTABLE": sys.executable,
            "nanobind_DIR": nanobind.stdout.strip(),
        }
        options = [f"-D{name}={value}" for name, value in defined.items()]
        self._run(["cmake", "-G", "Ninja", "-S", str(self.source), "-B", str(self.build), *options])

    def _targets(self) -> list[str]:
        """Return the names of the modules and of the programs to compile."""
        listed = self._run(["cmake", "--build", str(self.build), "--target", "help"])
        names = set(re.findall(r"^([\w-]+):", listed, re.M))
        simd = next(name.removeprefix("_engine_") for name in sorted(names) if re.fullmatch(r"_engine_\w+", name))
        programs = [n for name in PROGRAMS for n in (f"{name}-{simd}", name) if n in names]
        return ["_core", f"_engine_{simd}", *programs]

    def _commands(self, targets: Sequence[str]) -> list[dict[str, str]]:
        """Return the commands that compile the sources of targets."""
        listed = json.loads((self.build / "compile_commands.json").read_text())
        names = "|".join([*targets, *(f"fastlines{name}" for name in targets if name.startswith("_engine_"))])
        objects = re.compile(rf"CMakeFiles/(?:{names})\.dir/")
        commands = [command for command in listed if objects.search(command["command"])]
        return [c for c in commands if "nb_" not in Path(c["file"]).name]

    def _errors(self, command: dict[str, str]) -> set[tuple[str, int]]:
        """Check the syntax of a source; return the places of the core that its errors name."""
        check = re.sub(r" -o \S+ -c ", " -fsyntax-only -c ", command["command"])
        done = subprocess.run(check, shell=True, cwd=command["directory"], capture_output=True, text=True)
        if done.returncode == 0:
            return set()
        core, wrong = str(self.source / CORE), set[tuple[str, int]]()
        innermost: tuple[str, int] | None = None
        for line in done.stderr.splitlines():
            m = re.match(r"(\S+?):(\d+):(?:\d+:)? (.*)", line)
            if not m:
                if line.startswith(("In file", "/")) and "In instantiation" in line:
                    innermost = None
                continue
            path = os.path.normpath(os.path.join(command["directory"], m[1]))
            at = (os.path.relpath(path, core), int(m[2])) if path.startswith(core) else None
            if "required from" in m[3] and innermost is None:
                innermost = at
            elif " error:" in f" {m[3]}":
                wrong |= {place for place in (at or innermost,) if place}
                innermost = None
        if not wrong:
            raise InputError(f"{command['file']} does not compile:\n{done.stderr[:2000]}")
        return wrong

    def _compile(self) -> str:
        """Compile all targets, and put the modules into the package; return the end of an error, or ""."""
        targets = self._targets()
        command = ["cmake", "--build", str(self.build), "--target", *targets]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace")
        if done.returncode:
            return "\n".join(done.stdout.splitlines()[-20:]) or "cmake ends with an error"
        for target in targets[:2]:
            for module in self.build.glob(f"{target}.*"):
                if module.suffix in (".so", ".pyd"):
                    _write_changed(self.source / "src/fastlines" / module.name, module.read_bytes())
        self.programs = [self.build / "cpp/tests" / name for name in targets[2:]]
        return ""

    def _run(self, command: list[str]) -> str:
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            last = "\n".join((done.stdout + done.stderr).strip().splitlines()[-20:])
            raise InputError(f"{' '.join(command[:3])} … failed in {self.folder}:\n{last}")
        return done.stdout


def _lines(each: Found) -> set[tuple[str, int]]:
    return {(each.mutant.file, line) for line in range(each.mutant.line, each.last_line + 1)}


def _write_changed(path: Path, data: bytes) -> None:
    """Write a file unless it has these bytes, so that nothing is compiled again for it."""
    if not path.exists() or path.read_bytes() != data:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def _copy_changed(source: Path, target: Path, left: set[Path], root: Path) -> None:
    """Copy a file or a folder but for what is compiled and for some files."""
    for path in [source] if source.is_file() else source.rglob("*"):
        is_compiled = path.suffix in (".so", ".pyc", ".pyd") or "__pycache__" in path.parts
        if path.is_file() and not is_compiled and not path.is_symlink() and path.relative_to(root) not in left:
            _write_changed(target if source.is_file() else target / path.relative_to(source), path.read_bytes())
