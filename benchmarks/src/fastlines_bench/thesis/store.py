"""Work in named steps whose results are stored in files, so that an interrupted run resumes."""

from __future__ import annotations

import hashlib
import json
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from ..harness.internals import atomic_write

#: The result of a step, ready for JSON. "images" has the names of its picture files.
Found: TypeAlias = dict[str, Any]
Results: TypeAlias = dict[str, Found]

#: Increased when the meaning of the results changes.
FORMAT = 3


@dataclass(frozen=True)
class Step:
    """A named part of the work.

    Attributes
    ----------
    name : str
    weight : float
        Its approximate time, in a unit that all steps share.
    make : callable
        Returns the result, given those of the steps before it.
    """

    name: str
    weight: float
    make: Callable[[Results], Found]


class Store:
    """A folder with the results of steps.

    Parameters
    ----------
    folder : Path
        Created if it does not exist.
    key : object
        Everything that the steps depend on. Results that were stored under another key are computed again.
    """

    def __init__(self, folder: Path, key: object) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self.key = hashlib.sha256(repr((FORMAT, key)).encode()).hexdigest()[:16]

    def path(self, name: str, extension: str) -> Path:
        """Return the path of the file for a name."""
        return self.folder / (re.sub(r"\W+", "-", name.lower()).strip("-") + extension)

    def read(self, name: str) -> Found | None:
        """Return the stored result of a step; None if it is missing, incomplete or of another key."""
        try:
            kept = json.loads(self.path(name, ".json").read_text(encoding="utf-8"))
            images = kept["found"].get("images", {}).values()
            if kept["key"] == self.key and all((self.folder / image).is_file() for image in images):
                found: Found = {**kept["found"], "seconds": kept["seconds"]}
                return found
        except (OSError, ValueError, LookupError, TypeError, AttributeError):
            pass
        return None

    def write(self, name: str, found: Found, seconds: float) -> None:
        """Store the result of a step."""
        kept = {"name": name, "key": self.key, "seconds": seconds, "found": found}
        with atomic_write(self.path(name, ".json")) as partial:
            partial.write_text(json.dumps(kept, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def run_steps(steps: Sequence[Step], store: Store, show_progress: bool = False) -> Results:
    """Run all steps without a stored result; return the results of all steps, with their seconds."""
    results: Results = {}
    kept = {step.name: store.read(step.name) for step in steps}
    to_do = [step for step in steps if kept[step.name] is None]
    with _bar(to_do, len(steps), show_progress) as begin:
        for step in steps:
            found = kept[step.name]
            if found is None:
                begin(step)
                start = time.perf_counter()
                found = step.make(results)
                seconds = time.perf_counter() - start
                store.write(step.name, found, seconds)
                found = {**found, "seconds": seconds}
            results[step.name] = found
    return results


def time_left(weights: Mapping[str, float], done: Sequence[str], seconds: float) -> float | None:
    """Estimate the seconds of the remaining steps from those of the done ones; None if none is done.

    Examples
    --------
    >>> time_left({"a": 1, "b": 2, "c": 4}, ["a"], 20.0)
    120.0
    """
    known = sum(weights[name] for name in done)
    return seconds * (sum(weights.values()) / known - 1) if known else None


@contextmanager
def _bar(to_do: Sequence[Step], n_steps: int, show: bool) -> Iterator[Callable[[Step], None]]:
    """Show the current step and the time left, if `show`; yield a function to call before each step."""
    if not show:
        yield lambda step: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn
    from rich.text import Text

    weights = {step.name: step.weight for step in to_do}
    done: list[str] = []
    start = time.perf_counter()

    class Left(ProgressColumn):
        """A column that counts down from the estimate at the start of the step."""

        def render(self, task: Task) -> Text:
            end = task.fields["end"]
            left = 0.0 if end is None else end - time.perf_counter()
            words = f"about {left / 60:.0f} min left" if left >= 90 else f"about {left:.0f} s left"
            return Text(words if left > 0 else "")

    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=10),
        TextColumn("{task.fields[at]} of {task.fields[of]}"),
        TimeElapsedColumn(),
        Left(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        n_kept = n_steps - len(to_do)
        task = bar.add_task("", total=sum(weights.values()), at=n_kept, of=n_steps, end=None)

        def begin(step: Step) -> None:
            now = time.perf_counter()
            left = time_left(weights, done, now - start)
            bar.update(
                task,
                description=f"{step.name:<30}",
                completed=sum(weights[name] for name in done),
                at=n_kept + len(done) + 1,
                end=None if left is None else now + left,
            )
            done.append(step.name)

        yield begin
