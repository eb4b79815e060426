"""How long tests wait for programs. It guards against hanging for ever and is no measure: machines may be busy."""

HANGS = 1800.0  # seconds
