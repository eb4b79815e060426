"""Backends that change the answers of another one."""
