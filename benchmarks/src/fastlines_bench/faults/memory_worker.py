"""A process with one of the libraries loaded, in which the calls of one operation fail in turn.

It prints a line of JSON before each try, so that its end in the midst of one is seen, and one at the end.
"""

from __future__ import annotations

import ctypes
import gc
import sys
from pathlib import Path

import fastlines as fl

from ..harness.internals import FastlinesError
from .library import ALL, MEMORY, THREADS, FailingMemory
from .memory_operations import N_THREADS, Operation, Operations, arrays_of
from .turns import tell

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

    def run(self, n: int) -> tuple[bool, str]:
        """Fail call n; return whether it was reached, and what was wrong after it, or nothing."""
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

    def check_after(self) -> str:
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
            trial.run(n)
        grown.append((bytes_in_use() - before) / repeats)
    return max(0.0, min(grown))


def fail_in_turn(trial: MemoryTrial, first: int) -> None:
    """Fail call first and each after it, until a run has no such call."""
    n = first
    while True:
        tell(trying=n)
        was_reached, wrong = trial.run(n)
        if not was_reached:
            break
        wrong = wrong or trial.check_after()
        if wrong:
            tell(n=n, wrong=wrong)
        n += 1
    tell(n_calls=n - 1, leaked=leaked(trial, n - 1) if n > 1 else 0)


def main(name: str, mode: str, first: str, folder: str) -> None:
    """Run one operation in one mode, from one call on."""
    fl.set_num_threads(N_THREADS)
    operations = Operations(Path(folder))
    operation = next(each for each in operations if each.name == name)
    fail_in_turn(MemoryTrial(operation, operations, mode), int(first))


if __name__ == "__main__":
    main(*sys.argv[1:])
