"""Lines as neurons of navis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import FileWarning
from ..geometry.lines import Lines
from ..geometry.neurons import NEURON
from ..io.formats.swc import nodes_of
from ..io.losses import not_held
from ..io.polylines import polylines_of
from ..io.writing import to_written
from ..support.optional import optional
from ..support.units import meters_of
from ..support.warn_caller import warn_caller


def to_neurons(lines: Any) -> Any:
    """Return lines as a ``navis.NeuronList``: a TreeNeuron for each value of the attribute ``neuron``, or one of all.

    Where all ends of segments have an ``id``, as lines of neurons and of ``.swc`` files do, nodes are these ids, and so
    the trees stay whole. Otherwise each strand is a tree of its own. `lines` reads the neurons back.

    Parameters
    ----------
    lines : Lines, Curves, or what `fastlines.lines` takes
        Curves are cut into the pieces that queries test.

    Returns
    -------
    navis.NeuronList
        Its nodes have the radius, and the attribute ``type`` as ``label``. The unit is ``units``. Strands become the
        unbranched sections of the trees.

    Raises
    ------
    InputError
        If `lines` are something else.
    MissingExtraError
        If navis is not installed.

    Warns
    -----
    FileWarning
        Of everything that neurons cannot hold.

    Examples
    --------
    >>> import fastlines as fl
    >>> fork = [[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [2, 1, 0]], [[1, 0, 0], [2, -1, 0]]]
    >>> lines = fl.Lines.from_segments(fork, radius=0.1, end_attributes={"id": [[1, 2], [2, 3], [2, 4]]})
    >>> fl.to_neurons(lines)[0].n_leafs
    2
    """
    navis, pandas = (optional(library, "a list of neurons", "navis") for library in ("navis", "pandas"))
    straight, lost = to_written(lines, (Lines,), "neurons", "to_neurons({})")
    is_length = straight.unit is not None and meters_of(straight.unit) is not None
    neurons = []
    unit = straight.unit if is_length else None
    for part in _each_neuron(straight):
        polylines = polylines_of(part)
        nodes, kept = nodes_of(part, polylines)
        x, y, z = nodes.points.T
        table = {"node_id": nodes.ids, "label": nodes.types, "x": x, "y": y, "z": z, "radius": nodes.radius}
        frame = pandas.DataFrame(table | {"parent_id": nodes.parents})
        neurons.append(navis.TreeNeuron(frame, units=unit))
        lost += not_held(part, polylines, radius=True, attributes=kept, strands=True, unit=unit)
    if lost:
        warn_caller(f"not kept in the neurons: {'; '.join(dict.fromkeys(lost))}", FileWarning)
    return navis.NeuronList(neurons)


def _each_neuron(lines: Lines) -> Iterator[Lines]:
    """Yield the lines of each neuron."""
    numbers = lines.attributes.get(NEURON)
    if numbers is None or numbers.ndim > 1 or NEURON in lines.end_attributes:
        if len(lines):
            yield lines
        return
    values, which = np.unique(numbers, return_inverse=True)  # NaN is a value, too
    for i in range(len(values)):
        part = lines.select(prims=which == i)
        attributes = {name: values for name, values in part.attributes.items() if name != NEURON}
        yield replace(part, attributes=attributes)
