"""The answers and the speed of queries on a GPU, beside the CPU: ``fastlines-bench cuda``."""
