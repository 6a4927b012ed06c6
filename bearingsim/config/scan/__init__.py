"""Measured depth maps of defects and roundness profiles of races: reading, checks and repairs."""
