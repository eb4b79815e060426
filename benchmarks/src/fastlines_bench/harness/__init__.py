"""What all benchmarks share: subjects, rays, turns and the clock, presets, tables, plots and kept steps."""
