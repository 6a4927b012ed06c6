"""Integrators: a NamedTuple of parameters and one ``step`` each; ``advance`` drives any of them.

Its ``KIND`` says what others must know of it; ``build`` registers it under its name.
"""
