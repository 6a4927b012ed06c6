"""Scalar laws of contact and friction."""
