"""Models of increasing detail, each a module with a ``NamedTuple`` of parameters and interface functions.

The functions are those of ``interface.py``. A model's ``KIND`` describes it to the rest of the program; ``build``
registers it under its name.
"""
