"""Stability map of the methods: a matrix of materials and steps, each run judged."""
