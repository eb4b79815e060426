"""Benchmarks of fastlines: its queries against Embree's, its builders against each other, and the thesis repeated.

A folder holds what measures one subject, as plain data; `cli` has a module for each command of ``fastlines-bench``.
"""
