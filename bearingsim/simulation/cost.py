"""What a run takes: the ball passes that are computed of it, and those that prove its step, at what they cost."""

from math import ceil, sqrt
from typing import NamedTuple

from bearingsim.assemble.scales import at_full_speed
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.simulation.pilot import check_cost
from bearingsim.simulation.prices import per_second, price
from bearingsim.simulation.repetition import may_repeat, period_is_sought
from bearingsim.simulation.settling import extrapolation_passes


class Cost(NamedTuple):
    """CPU time of a run, s: of its steps, of their proof, and of both if a motion does not repeat that might.

    passes: ball passes that are computed; one_pass: s.
    """

    steps: float
    proof: float
    at_most: float
    passes: int
    one_pass: float

    @property
    def whole(self) -> float:
        """Steps and proof."""
        return self.steps + self.proof


def cost(case: Case, step: float, passes: int | None = None) -> Cost:
    """The cost of a case, its method named, at steps (of an adaptive method: recorded instants) of ``step`` s.

    passes: of all of the run, if more is known of it than its duration.
    """
    rate = case.bearing.ball_pass_frequency(at_full_speed(case).speed)
    whole = passes or ceil((case.settle_s + case.duration) * rate)
    one_pass = per_second(case, step) / rate
    if solved_once(case):
        whole = 1
    proof = check_cost(case) * whole if case.checks_step else 0.0
    before = extrapolation_passes(case)
    at_most = one_pass * (before + whole + proof)
    computed = whole
    in_a_period = min(whole, int(price("passes")))
    if may_repeat(case):
        computed = in_a_period
    if case.checks_step and period_is_sought(case):
        proof = sqrt(5.0) * (price("finer passes") + before)
        if not case.periodic:
            proof += before + in_a_period
    computed += before
    return Cost(one_pass * computed, one_pass * proof, at_most, computed, one_pass)


def solved_once(case: Case) -> bool:
    """Check if one ball pass is all that is computed: each instant stands alone, and each pass is the same."""
    return MODELS[case.model].memoryless and may_repeat(case)
