"""Stability map of the methods: a matrix of classified runs over materials and steps."""
