"""Measured depth maps: read from a file, checked, repaired."""
