"""Outcomes of a run as numbers for compiled code; ``simulation`` translates them into messages."""

SUCCESS = 0
STEP_LIMIT_EXCEEDED = 1  # step over a body's stability limit for too long
NOT_FINITE = 2
TOO_DEEP = 3  # approach of a contact above all values possible in the case
TOO_MUCH_ENERGY = 4  # more kinetic energy than load and defects can supply
STEP_TOO_SMALL = 5  # an adaptive step became too short
NEWTON_FAILED = 6  # an implicit step has no solution or did not converge
TOO_MANY_STEPS = 7  # too many steps between two recorded instants
CROSSINGS_MISSED = 8  # steps too long to count all crossings of a defect
TOO_SLOW = 9  # more CPU time than allowed for a job

NO_BODY = -1  # no body in particular
