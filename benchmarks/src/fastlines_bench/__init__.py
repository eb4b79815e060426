"""Benchmarks of fastlines: its queries against Embree's, its builders against each other, and the thesis repeated.

Each command of ``fastlines-bench`` has its own module or package, which measures and returns plain data. `harness`
holds the shared code.
"""
