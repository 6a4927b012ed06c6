"""The friction coefficient of one contact as a function of its slip.

A law gives what ``interface.py`` declares; ``lag.py`` is what a step makes of it, whichever the law.
"""
