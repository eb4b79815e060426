"""The shared parts of the benchmarks: subjects, rays, alternation, the clock, presets, tables, plots, stored steps."""
