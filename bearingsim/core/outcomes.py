"""Outcomes of a run, as numbers for compiled code; ``simulation`` has the words for them."""

SUCCESS = 0
STEP_LIMIT_EXCEEDED = 1  # a body stayed over the method's step limit
NOT_FINITE = 2
TOO_DEEP = 3  # a contact is pressed deeper than anything in the case can press it
TOO_MUCH_ENERGY = 4  # more energy of motion than load and defects can give
STEP_TOO_SMALL = 5  # an adaptive step became too short to go on
NEWTON_FAILED = 6  # no solution of an implicit step was found
TOO_MANY_STEPS = 7  # too many steps between two recorded instants
SKIPPED = 8  # crossings of a defect were not seen
TOO_SLOW = 9  # more CPU time than a job may take

NO_BODY = -1  # no body in particular
