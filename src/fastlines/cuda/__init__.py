"""Queries on GPUs: kernels of cpp/fastlines/device, compiled at run time."""
