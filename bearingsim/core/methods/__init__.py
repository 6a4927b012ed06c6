"""Integrators: a NamedTuple of parameters and one ``step`` each; ``advance`` drives any of them."""
