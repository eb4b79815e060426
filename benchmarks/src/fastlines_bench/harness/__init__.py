"""What all benchmarks share: subjects, rays, alternation, the clock, presets, tables, plots."""
