"""Streamlines of a flow, coloured by speed: `python examples/streamlines.py streamlines.png`."""

import sys
from typing import Any

import numpy as np

import fastlines as fl


def flow(p: Any) -> Any:
    """Return the velocity of the flow of Arnold, Beltrami and Childress at points (n, 3)."""
    x, y, z = p.T
    return np.stack([np.sin(z) + np.cos(y), np.sin(x) + np.cos(z), np.sin(y) + np.cos(x)], axis=1)


def streamlines(n: int, steps: int, dt: float = 0.05) -> fl.Lines:
    """Follow n particles by the method of Runge and Kutta of order 2."""
    path = [np.random.default_rng(1).uniform(0, 2 * np.pi, (n, 3))]
    for _ in range(steps):
        path.append(path[-1] + dt * flow(path[-1] + dt / 2 * flow(path[-1])))
    points = np.stack(path, axis=1).reshape(-1, 3)
    speed = np.sqrt((flow(points) ** 2).sum(axis=1))
    return fl.Lines.from_points(points, [steps + 1] * n, attributes={"speed": speed})


def main(path: str, size: int = 1024, n: int = 1500) -> None:
    """Render the picture."""
    lines = streamlines(n, 60)
    picture = fl.render(lines, width=size, height=size, look="fibre", color="speed", color_map="magma", legend=True)
    picture.save(path)
    print(f"{path}: {n} streamlines, coloured by speed")


if __name__ == "__main__":
    main(*sys.argv[1:2], *map(int, sys.argv[2:]))
