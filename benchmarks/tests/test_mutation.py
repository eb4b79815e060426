"""The command ``mutation``: the mutants of a small source, each in turn, and a warm process that runs tests."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import refused

from fastlines_bench.mutation import trial
from fastlines_bench.mutation.cpp_build import HEADER
from fastlines_bench.mutation.cpp_mutants import find_mutants, mutants_of, mutated
from fastlines_bench.mutation.equal import mark_equal, reasons
from fastlines_bench.mutation.mutant import Mutant, score
from fastlines_bench.mutation.python_sources import MutatedSources
from fastlines_bench.mutation.switches import VARIABLE, Switches

pytestmark = [
    pytest.mark.usefixtures("in_own_folder"),
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the switches are shared memory, on Linux"),
]

CHECKOUT = Path(__file__).resolve().parents[2]
SOURCE = """
#include <algorithm>
#include <cstdio>

constexpr int kTwo = 1 + 1;  // + of a constant stays

// a < b in a comment
int answer(int a, int b, bool flag) {
  int n = 0;
  if (a < b && !flag) n += std::max(a, b);
  for (int i = 0; i < kTwo; ++i) n = n * 10 + a;
  return n;
}

int main() {
  std::printf("%d %d %d", answer(1, 2, false), answer(2, 2, false), answer(1, 2, true));
}
"""

TESTS = """
import os, signal, time
from pathlib import Path

def number():
    return next((n for n, byte in enumerate(Path(os.environ["FASTLINES_MUTANTS"]).read_bytes()) if byte), 0)

def test_passes():
    pass

def test_fails():
    assert number() != 1

def test_crashes():
    if number() == 2:
        os.kill(os.getpid(), signal.SIGSEGV)

def test_hangs():
    if number() == 3:
        time.sleep(60)
"""


def test_mutants_of_a_source():
    found = mutants_of(Path("a.hpp"), SOURCE, 1)
    changes = {(each.mutant.original, each.mutant.replacement) for each in found}
    assert ("(a < b", "(a <= b") in changes
    assert ("&& !flag", "&& true") in changes
    assert ("std::max(a, b)", "std::min(a, b)") in changes
    assert ("std::max(a, b)", "(a)") in changes
    assert ("n * 10", "n / 10") in changes
    assert not [each for each in found if each.mutant.line in (5, 7)]
    assert [each.mutant.number for each in found] == list(range(1, len(found) + 1))


@pytest.mark.skipif(shutil.which("g++") is None, reason="there is no g++")
def test_each_mutant_is_a_choice_on_its_switch():
    found = [each for each in mutants_of(Path("a.hpp"), SOURCE, 1) if each.place.end < SOURCE.index("int main")]
    text, written = mutated(SOURCE, found)
    assert written == {each.mutant.number for each in found}
    assert len(text.splitlines()) == len(SOURCE.splitlines())
    Path("a.cpp").write_text(text)
    command = ["g++", "-std=c++20", "-O1", "-w", "-include", str(HEADER), "a.cpp", "-o", "program"]
    subprocess.run(command, check=True)
    switches = Switches(Path("switches"))

    def output() -> str:
        environment = {**os.environ, VARIABLE: "switches"}
        return subprocess.run(["./program"], env=environment, capture_output=True, text=True, timeout=10).stdout

    numbers = [each.mutant.number for each in found]
    switches.watch(numbers)
    assert output() == "211 22 11"
    assert switches.reached(numbers) == numbers
    for each in found:
        switches.only(each.mutant.number)
        assert output() != "211 22 11", each.mutant


def test_a_warm_process_runs_tests():
    Path("test_some.py").write_text(TESTS)
    switches = Switches(Path("switches"))
    command = [sys.executable, "-m", "fastlines_bench.mutation.warm_pytest", "-c", os.devnull, "test_some.py"]
    environment = {**os.environ, VARIABLE: "switches"}
    process = subprocess.Popen(command, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    names = [f"test_some.py::test_{name}" for name in ("passes", "fails", "crashes", "hangs")]
    assert process.stdin
    assert process.stdout
    assert json.loads(process.stdout.readline()) == {"collected": 4}
    ends = []
    for number in range(4):
        switches.only(number)
        process.stdin.write(json.dumps({"run": names, "seconds": 1.0}) + "\n")
        process.stdin.flush()
        answer = json.loads(process.stdout.readline())
        if "failed" in answer:
            assert answer["failed"] == f"{names[1]}, call"
            answer = json.loads(process.stdout.readline())
        ends.append(answer["end"])
    process.communicate("")
    assert ends == ["0", "1", "SIGSEGV", "hangs"]


def test_the_score_counts_equal_mutants_apart():
    (key, reason), *_ = reasons().items()
    statuses = [Mutant(1, key[0], 1, *key[1:4], "survived", nth=key[4]), Mutant(2, "a.hpp", 1, "", "", "", "killed")]
    statuses.append(Mutant(3, "a.hpp", 1, "", "", "", "survived"))
    assert score(statuses) == pytest.approx(1 / 3)
    mark_equal(statuses)
    assert [mutant.status for mutant in statuses] == ["equal", "killed", "survived"]
    assert statuses[0].by == reason
    assert score(statuses) == pytest.approx(1 / 2)


@pytest.mark.parametrize(("failing", "status"), [({1}, "killed"), (set(), "survived")])
def test_a_test_that_fails_without_a_mutant_notices_none(failing, status):
    class Worker:
        def record(self, numbers, progress):
            return [trial.Test(f"test_a.py::test_{name}", 0.1, frozenset({1})) for name in ("flaky", "b")]

        def noticed_by(self, number, groups):
            names = [test.name for group in groups for test in group]
            failed = [name for name in names if name.endswith("flaky") or number in failing]
            return f"{failed[0]}, call" if failed else ""

        def close(self):
            pass

    mutants = [Mutant(1, "a.hpp", 1, "", "", "")]
    trial.try_mutants([Worker()], mutants, 10.0, lambda *_: None, lambda _: None)
    assert mutants[0].status == status
    assert mutants[0].by == ("test_a.py::test_b, call" if failing else "")


def test_each_equal_mutant_is_one_that_is_made():
    mutants = [each.mutant for each in find_mutants(CHECKOUT)] + MutatedSources(CHECKOUT / "src" / "fastlines").mutants
    keys = [mutant.key for mutant in mutants]
    assert len(set(keys)) == len(keys)
    assert reasons().keys() <= set(keys)


def test_bad_options():
    assert "is no checkout of fastlines" in refused("mutation", "--checkout", ".")[1]
    assert "--language 'rust' is not a language" in refused("mutation", "--language", "rust")[1]
    Path("f.json").write_text("{}")
    assert "expected a file that --json wrote" in refused("mutation", "--again", "f.json")[1]
