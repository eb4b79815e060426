"""``fastlines-bench cuda``: the answers and the speed of queries on a GPU, beside the CPU."""

from .run import CudaPreset, run_cuda
from .show import print_cuda, print_variants
from .variants import VariantsPreset, run_variants

__all__ = ["CudaPreset", "VariantsPreset", "print_cuda", "print_variants", "run_cuda", "run_variants"]
