"""How long tests wait for programs: long enough for a busy machine, and a guard against hanging."""

HANGS = 1800.0  # seconds
