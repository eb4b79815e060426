"""Optimal trees for tiny inputs, and lower bounds for trees and searches (thesis §6.6; docs/theory.md has the proofs).

Trees, costs and splits are those of `fastlines.theory`.
"""

from .bound import lower_bound
from .lattice import grid_optimum
from .least import at_least, at_least_cut, gain
from .oracle import even_planes, optimum, partitions, planes_at
from .pairs import at_least_of_pairs

__all__ = [
    "at_least",
    "at_least_cut",
    "at_least_of_pairs",
    "even_planes",
    "gain",
    "grid_optimum",
    "lower_bound",
    "optimum",
    "partitions",
    "planes_at",
]
