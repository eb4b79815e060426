"""Files of rays, as ``fastlines query`` reads them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import InputError
from .array_files import load_array, load_arrays


def read_rays(path: str) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Read rays from a .npy or .npz file."""
    if not path.lower().endswith((".npy", ".npz")):
        raise InputError(f"{path}: rays are read from .npy, an array (n, 6), or .npz, with origins and directions")
    if path.lower().endswith(".npz"):
        arrays = load_arrays(path, "rays", ("origins", "directions"))
        missing = {"origins", "directions"} - arrays.keys()
        if missing:
            raise InputError(f"{path}: has no array {' and no '.join(sorted(missing))}; expected both")
        return arrays["origins"], arrays["directions"]
    loaded = load_array(path, "rays")
    if loaded.ndim != 2 or loaded.shape[1] != 6:
        raise InputError(f"{path}: has the shape {loaded.shape}; expected (n, 6): origin and direction of each ray")
    return np.asarray(loaded[:, :3]), np.asarray(loaded[:, 3:])
