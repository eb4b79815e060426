"""The scattering of hair beside Mitsuba's, and averaged hair beside sums: ``fastlines-bench hair``."""
