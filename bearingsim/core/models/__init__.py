"""The ladder of models: each a module with a ``NamedTuple`` of parameters and the functions of ``interface.py``.

Its ``KIND`` says what others must know of it; ``build`` registers it under its name.
"""
