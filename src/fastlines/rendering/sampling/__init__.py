"""Sample points: low-discrepancy numbers, and where they lie in a pixel."""
