"""Elastic laws: the elastic force of one contact, and the division of an approach between two contacts in series.

A law implements the functions of ``interface.py``. The balance of two laws in series is then solved by Newton's
method (``series.py``); for a closed form a power law defines ``as_power``, any other law its own
``inner_approach``.
"""
