"""``fastlines-bench cuda``: the answers and the speed of queries on a GPU, beside the CPU."""

from .run import CudaPreset, run_cuda
from .show import print_cuda

__all__ = ["CudaPreset", "print_cuda", "run_cuda"]
