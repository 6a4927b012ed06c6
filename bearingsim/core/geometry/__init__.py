"""Positions and motion of bodies."""
