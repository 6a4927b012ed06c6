"""Damping laws: the normal force of one contact, its elastic force included.

A damping law stores its elastic law (``laws/stiffness``), so one value describes the whole contact:
``HuntCrossley(TenNinths(k), chi)``. Each law implements the functions of ``interface.py``.
"""
