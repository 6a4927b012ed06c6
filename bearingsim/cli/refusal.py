"""The error of a command that cannot do what it was asked."""

__all__ = ["Refusal"]


class Refusal(Exception):
    """What is wrong, in words for the user."""
