"""Integrators: a NamedTuple of parameters and one ``step`` each; ``advance`` drives any of them.

``KIND`` describes the properties of a method; ``build`` registers it under its name.
"""
