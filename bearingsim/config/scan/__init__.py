"""Measured depth maps of defects: reading, checks and repairs."""
