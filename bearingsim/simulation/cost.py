"""CPU time of a run: of the ball passes that are computed, and of those that check its step."""

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
    """CPU time (s) of a run: of its steps, of their check (proof), and of both if the response is not periodic.

    passes: computed ball passes; one_pass: CPU time (s) of one.
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
    """Estimate the cost of a case, its method named, at steps of ``step`` s (adaptive: between recorded instants).

    passes: ball passes of the whole run, if not those of settling and duration.
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
    """Check if one ball pass is all that is computed: the model has no memory and every pass is the same."""
    return MODELS[case.model].memoryless and may_repeat(case)
