"""The elastic force of one contact, and how two in series share an approach.

A law gives what ``interface.py`` declares. Two laws in series then balance by Newton's method (``series.py``);
where the balance has a closed form, the law says so: a power law by ``as_power``, any other by its own ``share``.
"""
