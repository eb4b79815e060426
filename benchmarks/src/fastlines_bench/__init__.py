"""Benchmarks of fastlines: its queries beside Embree's, its builders beside each other, and the thesis made again.

Each command of ``fastlines-bench`` has a module or package of its own, which measures, and gives its result as plain
data; `harness` holds what they share.
"""
