"""A process with one of the libraries loaded, in which the calls of one operation fail in turn.

It prints a line of JSON before each try, so that its end in the midst of one is seen, and one at the end.
"""

from __future__ import annotations

import ctypes
import gc
import sys
from functools import partial
from pathlib import Path

import fastlines as fl

from ..harness.internals import FastlinesError
from .library import ALL, MEMORY, THREADS, FailingMemory
from .memory_operations import N_THREADS, Operation, Operations, arrays_of
from .turns import fail_in_turn

#: The members of the struct mallinfo2.
MALLINFO = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost"


class Mallinfo(ctypes.Structure):
    """What the allocator of glibc has handed out."""

    _fields_ = [(name, ctypes.c_size_t) for name in MALLINFO.split()]


def bytes_in_use() -> int:
    """Return how many bytes the allocator has handed out."""
    gc.collect()
    mallinfo = ctypes.CDLL(None).mallinfo2
    mallinfo.restype = Mallinfo
    info = mallinfo()
    return int(info.uordblks + info.hblkhd)


def is_sentence(error: BaseException) -> bool:
    """Return whether an error says in one line what happened."""
    known = isinstance(error, MemoryError | FastlinesError | OSError)
    return known and "\n" not in str(error)


class MemoryTrial:
    """An operation whose n-th allocation, or all from there, or n-th new thread fails."""

    def __init__(self, operation: Operation, operations: Operations, mode: str) -> None:
        self.operation, self.operations, self.mode = operation, operations, mode
        self.library = FailingMemory()
        self.expected = arrays_of(operation.prepare()())
        self.before = operations.check()

    def run(self, n: int) -> tuple[bool, str, list[str]]:
        """Fail call n; return whether it was reached, the kind of call, and what is wrong after it."""
        was_reached, wrong = self.fail(n)
        if was_reached:
            wrong = wrong or self._check_after()
        return was_reached, self.mode, [wrong] if wrong else []

    def fail(self, n: int) -> tuple[bool, str]:
        """Fail call n; return whether it was reached, and what is wrong with the call, or nothing."""
        call, answer, error = self.operation.prepare(), None, None
        kind = THREADS if self.mode == "threads" else MEMORY
        self.library.arm(kind, n, n if self.mode == "once" else ALL)
        try:
            answer = call()
        except BaseException as caught:
            error = caught
        n_calls = self.library.disarm()
        wrong = ""
        if error is None:
            if arrays_of(answer) != self.expected:
                wrong = "another answer without an error"
        elif not is_sentence(error):
            wrong = f"{type(error).__name__}: {error}"
        del answer, error, call
        return n_calls >= n, wrong

    def _check_after(self) -> str:
        """Return what is wrong with the trees from before, and with the next call, or nothing."""
        if self.operations.check() != self.before:
            return "a tree from before answers differently"
        if arrays_of(self.operation.prepare()()) != self.expected:
            return "the next call answers differently"
        return ""


def leaked(trial: MemoryTrial, n_calls: int, repeats: int = 50, rounds: int = 24) -> float:
    """Return the bytes that stay in use, for each of many faults spread over all calls.

    That is the least of several rounds, as the pool of pages keeps blocks of 64 KB and more for reuse, now and then
    another one, until it has enough of them.
    """
    turns = [1 + i * max(1, n_calls - 1) // repeats for i in range(repeats)]
    grown: list[float] = []
    while len(grown) < rounds and min(grown, default=ALL) > 0:
        before = bytes_in_use()
        for n in turns:
            trial.fail(n)
        grown.append((bytes_in_use() - before) / repeats)
    return max(0.0, min(grown))


def main(name: str, mode: str, first: str, folder: str) -> None:
    """Run one operation in one mode, from one call on."""
    fl.set_num_threads(N_THREADS)
    operations = Operations(Path(folder))
    operation = next(each for each in operations if each.name == name)
    trial = MemoryTrial(operation, operations, mode)
    fail_in_turn(trial.run, int(first), partial(leaked, trial))


if __name__ == "__main__":
    main(*sys.argv[1:])
