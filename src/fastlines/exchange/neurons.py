"""Lines as neurons of navis."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import FileWarning
from ..geometry.lines import Lines
from ..geometry.neurons import NEURON
from ..io.formats.swc import nodes_of
from ..io.writing import to_written
from ..support.optional import optional
from ..support.warn_caller import warn_caller


