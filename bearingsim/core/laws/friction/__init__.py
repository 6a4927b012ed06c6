"""Friction laws: the friction coefficient of one contact as a function of its slip speed.

A law implements the functions of ``interface.py``; ``lag.py`` makes the friction of any law implicit within a
step.
"""
