"""The elastic force of one contact, and the shares of two contacts in series in an approach.

A law implements the functions of ``interface.py``. The balance of two laws in series is then solved by Newton's
method (``series.py``); for a closed form a power law defines ``as_power``, any other its own ``inner_approach``.
"""
