"""Faults injected: allocations, new threads, and calls that write files fail in turn."""
