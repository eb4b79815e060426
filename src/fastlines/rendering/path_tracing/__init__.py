"""Light that is scattered many times."""
