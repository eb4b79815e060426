"""``fastlines-bench engine --shapes``: queries of round cones, cubic hair, spheres and triangles beside Embree's."""

from .names import SHAPES
from .result import Result
from .run import run_shapes
from .show import print_tables
from .subjects import shape_subjects

__all__ = ["SHAPES", "Result", "print_tables", "run_shapes", "shape_subjects"]
