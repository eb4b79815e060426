"""How long tests wait for programs: a guard against hanging for ever, as machines may be busy."""

HANGS = 1800.0  # seconds
