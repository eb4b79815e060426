"""Fuzzes the readers of line files and `fl.load`, guided by coverage (Atheris): ``python tests/fuzz/run.py [TARGET…]``.

Each run reads one damaged file. The seeds are in `corpora/TARGET`; ``--seeds`` writes them anew. Files that reach new
code are kept in `build/fuzz/corpora`. A file with a fault is `build/fuzz/TARGET-crash-…`; put it into `corpora/TARGET`,
whose files `test_corpora.py` replays. The output is a table in Markdown, with a row for each target.

Atheris: https://github.com/google/atheris. Of the package, only what reads files is instrumented.
"""

from __future__ import annotations

import argparse
import re
import resource
import subprocess
import sys
import time
import warnings
import zlib
from importlib.util import find_spec
from pathlib import Path
from random import Random

import numpy as np

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

#: What is instrumented.
CODE = ("fastlines.io", "fastlines.structure", "fastlines.support.container", "fastlines.support.metadata",
        "fastlines.support.text_columns", "fastlines.geometry.line_input")  # fmt: skip
#: A process may grow by so many bytes within so many runs.
MORE_BYTES, LIMITED = 1 << 30, 4096
#: A file is at most so long.
MAX_LENGTH = 4096
#: One run in so many is compared, and one in so many reads a file stretched to 64 KB.
COMPARED, STRETCHED = 16, 1024
LONG = 1 << 16


def main() -> None:
    """Fuzz some targets, each in a process of its own."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("targets", nargs="*", metavar="TARGET", help="all by default")
    parser.add_argument("--runs", type=int, default=2000, help="the most runs of each target")
    parser.add_argument("--seconds", type=int, default=0, help="the most seconds of each target; 0 is no limit")
    parser.add_argument("--seed", type=int, default=1, help="of the random changes")
    parser.add_argument("--folder", type=Path, default=HERE.parent.parent / "build" / "fuzz", help="what is found")
    parser.add_argument("--list", action="store_true", help="print the targets")
    parser.add_argument("--seeds", action="store_true", help="write the seeds of the corpora")
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.here:
        fuzz(given.targets[0], given)
        return
    import targets

    names = given.targets or [target.name for target in targets.TARGETS]
    if given.list:
        print("\n".join(names))
        return
    if given.seeds:
        for name in names:
            write_seeds(targets.by_name(name))
        return
    print(
        "| target | runs | seconds | edges | features | accepted | found |\n|---|--:|--:|--:|--:|--:|--:|", flush=True
    )
    sys.exit(max(0 if in_process(targets.by_name(name).name, given) else 1 for name in names))


def write_seeds(target) -> None:
    """Write the seeds of a target to its corpus."""
    folder = HERE / "corpora" / target.name
    folder.mkdir(parents=True, exist_ok=True)
    for i, data in enumerate(target.seeds()):
        (folder / f"seed-{i}.{target.extension}").write_bytes(data)


def in_process(name: str, given: argparse.Namespace) -> bool:
    """Fuzz one target in a process of its own; print its row; return whether nothing is found."""
    options = [f"--{key}={getattr(given, key)}" for key in ("runs", "seconds", "seed", "folder")]
    counted = given.folder / f"{name}.counts"
    counted.unlink(missing_ok=True)
    start = time.monotonic()
    done = subprocess.run(
        [sys.executable, __file__, name, "--here", *options], text=True, errors="replace", stderr=subprocess.PIPE
    )
    said, seconds = done.stderr, time.monotonic() - start
    n_runs, n_accepted = np.fromfile(counted, np.int64) if counted.is_file() else (0, 0)
    edges, features = (max(map(int, re.findall(rf"{key}: (\d+)", said)), default=0) for key in ("cov", "ft"))
    row = [name, n_runs, round(seconds), edges, features, n_accepted, int(done.returncode != 0)]
    print("| " + " | ".join(map(str, row)) + " |", flush=True)
    if done.returncode:
        print("\n".join(line for line in said.splitlines() if not line.startswith("INFO"))[-6000:], file=sys.stderr)
    return not done.returncode


def fuzz(name: str, given: argparse.Namespace) -> None:
    """Fuzz one target; the process ends with it."""
    import atheris

    given.folder.mkdir(parents=True, exist_ok=True)
    with atheris.instrument_imports(include=["fastlines"], exclude=other_modules()):
        import targets

        target = targets.by_name(name)
        for data in target.seeds():  # which imports all that they need
            targets.check(target, data)

    import fastlines as fl

    counts = np.memmap(given.folder / f"{name}.counts", np.int64, "w+", shape=2)
    warnings.simplefilter("error")
    warnings.filterwarnings("ignore", "Duplicate name")  # of archives that are made
    for kind in (ResourceWarning, fl.FileWarning, fl.PrecisionWarning, fl.QueryWarning):
        warnings.simplefilter("ignore", kind)
    fl.set_num_threads(1)
    corpora = [given.folder / "corpora" / name, HERE / "corpora" / name]
    for corpus in corpora:
        corpus.mkdir(parents=True, exist_ok=True)

    def one(data: bytes) -> None:
        choice = zlib.crc32(data)
        if counts[0] % LIMITED == 0:
            limit_memory()
        counts[0] += 1
        if not target.needs and (choice >> 12) % STRETCHED == 0:  # what other packages take is theirs
            target.run(stretched(data, choice), choice, False)
        counts[1] += target.run(data, choice, (choice >> 8) % COMPARED == 0)

    def mutate(data: bytes, most: int, seed: int) -> bytes:
        return target.mutate(bytes(data), most, Random(seed), lambda part, size: bytes(atheris.Mutate(part, size)))

    options = [f"-runs={given.runs}", f"-max_total_time={given.seconds}", f"-seed={given.seed}", "-timeout=10"]
    options += [f"-max_len={MAX_LENGTH}", "-mutate_depth=2", "-rss_limit_mb=0"]
    options.append(f"-artifact_prefix={given.folder / name}-")
    words = given.folder / f"{name}.words"
    if target.words:
        options.append(f"-dict={words}")
    words.write_text("".join(f'"{"".join(f"{chr(92)}x{byte:02x}" for byte in word)}"\n' for word in target.words))
    atheris.Setup([sys.argv[0], *options, *map(str, corpora)], one, custom_mutator=mutate)
    atheris.Fuzz()


def other_modules() -> list[str]:
    """Return the modules of the package that are not instrumented."""
    spec = find_spec("fastlines")
    root = Path(spec.origin).parent
    names = [".".join(file.relative_to(root.parent).with_suffix("").parts) for file in root.rglob("*.py")]
    names = [name.removesuffix(".__init__") for name in names]
    return [name for name in names if not name.startswith(CODE)]


def limit_memory() -> None:
    """Let an allocation out of proportion fail.

    The limit grows with the process, as Atheris 3.0 never frees the result of a comparison, such as an array.
    """
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MORE_BYTES, most))


def stretched(data: bytes, choice: int) -> bytes:
    """Repeat two parts of a file until it has 64 KB: what takes more than in proportion to a file shows there."""
    random = Random(choice)
    for most in (LONG // 2, LONG):
        start = random.randrange(len(data) + 1)
        part = data[start : start + random.choice((1, 2, 4, 16, 64, 256))]
        data = data[:start] + part * ((most - len(data)) // max(len(part), 1)) + data[start:]
    return data


if __name__ == "__main__":
    main()
