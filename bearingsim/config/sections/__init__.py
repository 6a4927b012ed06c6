"""Sections of a study file, with their fields."""
