"""``fastlines-bench cuda``: the answers and the speed of queries on a GPU, beside the CPU."""

from .resources import ResourcesPreset, run_resources
from .run import CudaPreset, run_cuda
from .show import print_cuda, print_resources, print_variants
from .variants import VariantsPreset, run_variants

__all__ = [
    "CudaPreset",
    "ResourcesPreset",
    "VariantsPreset",
    "print_cuda",
    "print_resources",
    "print_variants",
    "run_cuda",
    "run_resources",
    "run_variants",
]
