"""Queries as tasks: any `map`, such as an executor's, or workers of Dask answer chunks of rays and points."""
