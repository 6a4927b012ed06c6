"""The normal force of one contact: a damping law around an elastic one.

A damping law holds the elastic law (``laws/stiffness``) it goes with, so one value names the whole contact:
``HuntCrossley(TenNinths(k), chi)``. Each law gives what ``interface.py`` declares.
"""
