"""What all errors that a user can mend have in common."""


class UserError(Exception):
    """Its text says all that a user needs: the command line shows it without a traceback."""
