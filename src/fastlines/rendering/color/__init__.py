"""Colours, the tone curve and legends."""
