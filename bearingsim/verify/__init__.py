"""Elastic contact at the edge of a pit, solved in full: what the product's reduced contact is judged by.

Plane strain, no friction, small strains, no yielding, nothing moves: docs/edges.md. Finite elements need
scikit-fem (the extra ``verify``); half-spaces do not.
"""
