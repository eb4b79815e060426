"""PyVista as a peer: lines as tubes, off-screen: ``python -m fastlines_bench.peers.pyvista_tubes SOURCE PICTURE``.

Source: Sullivan and Kaszynski, "PyVista: 3D plotting and mesh analysis through a streamlined interface for the
Visualization Toolkit (VTK)", 2019; https://pyvista.org.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys

import numpy as np

#: The width and the height of the picture, and the radius of tubes as a fraction of the longest side of the lines.
SIZE, THICKNESS = 1024, 1 / 1000


def missing() -> str:
    """Return why PyVista cannot be timed; empty if it is installed."""
    return "" if importlib.util.find_spec("pyvista") else "PyVista is not installed; run  pip install pyvista"


def draw(source: str, picture: str) -> None:
    """Read a file of lines or make a scene, and draw tubes with the radius of the lines, or with a thin one."""
    fl = importlib.import_module("fastlines")
    pyvista = importlib.import_module("pyvista")
    name, *numbers = source.removeprefix("scene:").split(":")
    lines = fl.scenes.make(name, *map(int, numbers)).lines if source.startswith("scene:") else fl.read(source)
    plotter = pyvista.Plotter(off_screen=True, window_size=(SIZE, SIZE))
    for part in lines.each_part():
        mesh = fl.to_polydata(part)
        if "radius" in mesh.point_data:
            tubes = mesh.tube(scalars="radius", absolute=True, n_sides=8)
        else:
            tubes = mesh.tube(radius=THICKNESS * float(np.ptp(part.bounds, axis=0).max()), n_sides=8)
        plotter.add_mesh(tubes, scalars=None, color="tan", smooth_shading=True)
    plotter.screenshot(picture)


if __name__ == "__main__":
    draw(*sys.argv[1:3])
