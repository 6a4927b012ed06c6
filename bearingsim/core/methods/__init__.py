"""Integrators: each is a ``NamedTuple`` of parameters with one ``step``; ``advance`` runs any of them.

``KIND`` of a module describes the properties of its method; ``bearingsim/catalogue.py`` lists the modules.
"""
