"""The normal force of one contact: a damping law that contains an elastic one.

A damping law stores its elastic law (``laws/stiffness``), so one value describes the whole contact:
``HuntCrossley(TenNinths(k), chi)``. Each law implements the functions of ``interface.py``.
"""
