"""Data flows one way: a file includes or imports only what stands before it. Files are short and know nobody's disk."""

from __future__ import annotations

import ast
import graphlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CPP = ROOT / "cpp" / "fastlines"
PACKAGE = ROOT / "src" / "fastlines"
BENCHMARKS = ROOT / "benchmarks" / "src" / "fastlines_bench"
#: The modules at the top of the package; all others are in folders.
AT_THE_TOP = "__init__ __main__ _core _engine arrays builder camera engines errors progress refit threads tree"
#: The folders whose ``__init__`` has names of its own; that of others imports nothing, so that modules load alone.
FACES = (
    "",
    ".beams",
    ".cli",
    ".drawing",
    ".inspection",
    ".io",
    ".mitsuba",
    ".rendering",
    ".rendering.hair",
    ".rendering.looks",
    ".report",
    ".scenes",
    ".theory",
    ".trimesh",
)
#: The longest file, in lines, by suffix. Stubs are generated.
MAX_LINES = {".hpp": 350, ".cpp": 350, ".h": 350, ".pyi": 1000}
MAX_OTHER_LINES = 400


def table(heading: str, page: str = "CONTRIBUTING.md") -> tuple[str, ...]:
    """Read the first column of a table of a page, which shows the layers from the ground up."""
    rows = (ROOT / page).read_text(encoding="utf-8").split(f"| {heading} |")[1].split("\n\n")[0]
    return tuple(re.findall(r"^\| `([^`]+)` \|", rows, re.MULTILINE))


#: The C++ core, and the modules and packages of Python; "fastlines" is the package's own front door.
HEADERS = table("layer of the core")
MODULES = {
    PACKAGE: table("layer of the package"),
    BENCHMARKS: table("layer of the benchmarks", "benchmarks/README.md"),
}


def header_layer(header: str) -> int:
    named = [i for i, layer in enumerate(HEADERS) if header == layer or header.startswith(f"{layer}/")]
    assert named, f"{header} is in no layer: give it a row in CONTRIBUTING.md"
    return max(named, key=lambda i: len(HEADERS[i]))


def includes() -> dict[str, set[str]]:
    """Return what each header of the core includes, as paths from cpp/fastlines."""
    graph = {}
    for path in sorted(CPP.rglob("*.hpp")):
        found = re.findall(r'^\s*#\s*include\s+"([^"]+)"', path.read_text(encoding="utf-8"), re.MULTILINE)
        targets = {(path.parent / name).resolve() for name in found}
        assert all(target.is_file() for target in targets), f"{path} includes what is not in cpp/fastlines: {found}"
        graph[path.relative_to(CPP).as_posix()] = {target.relative_to(CPP.resolve()).as_posix() for target in targets}
    return graph


def test_headers_include_only_what_stands_before_them() -> None:
    graph = includes()
    assert len(graph) > 20
    upwards = [
        f"{header} includes {target}"
        for header, targets in graph.items()
        for target in targets
        if header_layer(target) > header_layer(header)
    ]
    assert upwards == []
    list(graphlib.TopologicalSorter(graph).static_order())
    assert {header_layer(header) for header in graph} == set(range(len(HEADERS))), "a layer is empty"


def test_the_core_knows_neither_python_nor_its_bindings() -> None:
    for path in [*CPP.rglob("*.hpp"), *(ROOT / "examples").rglob("*.cpp")]:
        assert not re.search(r"nanobind|Python\.h|bindings/", path.read_text(encoding="utf-8")), path


def python_modules(package: Path) -> dict[str, Path]:
    modules = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package.parent).with_suffix("").parts
        modules[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    modules |= {f"{package.name}.{path.stem}": path for path in package.glob("*.pyi")}
    return modules


def statements(node: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """Yield all imports, those inside functions too, but for those that only type checkers see."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child
        elif not (isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test)):
            yield from statements(child)


def imports(name: str, path: Path, known: dict[str, Path]) -> set[str]:
    """Return the modules of the package that a module imports."""
    package = name.split(".") if path.stem == "__init__" else name.split(".")[:-1]
    found = set()
    for statement in statements(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(statement, ast.Import):
            found |= {alias.name for alias in statement.names}
            continue
        base = package[: len(package) - statement.level + 1] if statement.level else []
        module = ".".join([*base, *(statement.module or "").split(".")]).strip(".")
        for alias in statement.names:
            inner = f"{module}.{alias.name}"
            found.add(inner if inner in known else module)
    return {target for target in found if target in known and target != name}


def module_layer(name: str, layers: tuple[str, ...]) -> int:
    """Return the row of the smallest folder that has one, or of a module at the top."""
    path = name.partition(".")[2].replace(".", "/") or name
    named = [i for i, layer in enumerate(layers) if path == layer or path.startswith(f"{layer}/")]
    assert named, f"{name} is in no layer: give it a row in the table of layers"
    return max(named, key=lambda i: len(layers[i]))


@pytest.mark.parametrize("package", MODULES, ids=lambda package: package.name)
def test_modules_import_only_what_stands_before_them(package: Path) -> None:
    known, layers = python_modules(package), MODULES[package]
    graph = {name: imports(name, path, known) for name, path in known.items() if path.suffix == ".py"}
    assert sum(map(len, graph.values())) > len(graph)
    upwards = [
        f"{name} imports {target}"
        for name, targets in graph.items()
        for target in targets
        if module_layer(target, layers) > module_layer(name, layers)
    ]
    assert upwards == []
    list(graphlib.TopologicalSorter(graph).static_order())
    assert {module_layer(name, layers) for name in known} == set(range(len(layers))), "a layer is empty"


def test_the_top_of_the_package_is_small() -> None:
    assert sorted(path.stem for path in PACKAGE.glob("*.py*")) == AT_THE_TOP.split()


def test_a_module_loads_without_its_neighbours() -> None:
    known = python_modules(PACKAGE)
    folders = {name: path for name, path in known.items() if path.stem == "__init__"}
    loading = {name for name, path in folders.items() if imports(name, path, known)}
    assert loading == {f"fastlines{face}" for face in FACES}


def test_a_kind_of_geometry_answers_for_itself() -> None:
    """Outside of `geometry`, these modules alone test for a class: one needs its type, and one takes only lines."""
    tests = re.compile(r"isinstance\([^)]*\b(Lines|Curves|Spheres|Triangles|Boxes|Mesh|Geometry|UserPrimitives)\b")
    files = {path.relative_to(PACKAGE).as_posix(): path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    found = {name for name, text in files.items() if tests.search(text) and not name.startswith("geometry/")}
    assert found == {"cli/files.py", "io/formats/usd_write.py"}


def own_files() -> list[Path]:
    """Return what is written by hand: not what builds, tools and documentation leave behind."""
    folders = ("src", "cpp", "tests", "docs", "benchmarks", "examples", ".ci")
    found = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.is_file()]
    found += [path for path in ROOT.iterdir() if path.suffix in (".md", ".toml", ".txt", ".cff")]
    made = re.compile(r"(^|/)(_build|build|_autosummary|__pycache__|\..*_cache|.*\.egg-info)(/|$)")
    return sorted(path for path in found if not made.search(path.relative_to(ROOT).as_posix()))


def is_source(path: Path) -> bool:
    return path.suffix in (".py", ".pyi", ".hpp", ".cpp", ".h", ".css", ".js")


@pytest.mark.parametrize("folder", ["src", "cpp", "tests", "benchmarks", "examples"])
def test_files_are_short(folder: str) -> None:
    sources = [path for path in own_files() if path.is_relative_to(ROOT / folder) and is_source(path)]
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in sources}
    assert len(lines) > 10 or folder in ("cpp", "examples")
    long = [
        f"{path.relative_to(ROOT)}: {n} lines"
        for path, n in lines.items()
        if n > MAX_LINES.get(path.suffix, MAX_OTHER_LINES)
    ]
    assert long == [], "look for the second thing in it"


def test_no_path_of_someones_disk() -> None:
    folders = "|".join(["work", "tmp", "root", "home", "Users", "private"])
    somewhere = re.compile(rf"(?<![\w.~*:/-])/({folders})/\w")
    for path in own_files():
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        assert [line for line in text.splitlines() if somewhere.search(line)] == [], path.relative_to(ROOT)
