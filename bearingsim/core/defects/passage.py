"""Passage of one roller over a defect between two fixed rings, or its impact on one of them.

    m x'' = Q_i(delta_i - x) - Q_o(delta_o + x) + Q_0

x: outward displacement (m) of the roller; delta_o, delta_i: approaches at rest; Q_0: force that balances the
roller at rest. Other rollers and the motion of the rings are neglected, so this is only an estimate of the peak
force, made before a run.
"""

from math import pi, sqrt

from bearingsim.core.clock import is_over
from bearingsim.core.defects.on_roller import force_over_defect
from bearingsim.core.defects.pairs import HALF_WIDTH, OUTER, SIDE, passing_speed
from bearingsim.core.jit import jit
from bearingsim.core.laws.damping.interface import damping_bound, normal_force, stiffness_bound

PASSAGE_STEPS = 400  # minimum number of steps from rim to rim
PERIOD_STEP = 0.1  # largest step of a passage, in units of sqrt(m/K), the time of one radian of oscillation
STEPS_PER_CHECK = 4096  # steps between two readings of the CPU clock
DECAY_TIMES = 10.0  # time simulated after a passage and one more crossing time, in units of sqrt(m/K) at rest


@jit
def passage_peak(model, d, delta_o, delta_i, cpu_end):
    """Return the largest contact force (N) during a roller's passage of roller-defect pair ``d``.

    delta_o, delta_i: approaches (m) of its contacts at rest; cpu_end: CPU time (s) of the thread at which the
    computation stops (``cpu_time.bounded``).
    """
    outer, inner, defects, m = model.outer, model.inner, model.defects, model.bearing.m_r
    speed, half_width = passing_speed(defects, d, model.bearing), defects.head[d, HALF_WIDTH]
    on_outer = defects.head[d, SIDE] == OUTER
    balance = normal_force(outer, delta_o, 0.0) - normal_force(inner, delta_i, 0.0)
    omega_rest = sqrt((stiffness_bound(outer, delta_o, 0.0) + stiffness_bound(inner, delta_i, 0.0)) / m)
    h_max, end = (
        2.0 * half_width / (abs(speed) * PASSAGE_STEPS),
        3.0 * half_width / abs(speed) + DECAY_TIMES / omega_rest,
    )
    t, x, v, peak = -half_width / abs(speed), 0.0, 0.0, normal_force(outer, delta_o, 0.0)
    n = 0
    while t < end and not (n % STEPS_PER_CHECK == STEPS_PER_CHECK - 1 and is_over(cpu_end)):
        n += 1
        s = speed * t
        over_defect = abs(s) < half_width
        d_o, d_i = delta_o + x, delta_i - x
        if over_defect and on_outer:
            Q_o, _, d_o, v_o = force_over_defect(outer, defects, d, s, speed, d_o, v)
        else:
            Q_o, v_o = normal_force(outer, d_o, v), v
        if over_defect and not on_outer:
            Q_i, _, d_i, v_i = force_over_defect(inner, defects, d, s, speed, d_i, -v)
        else:
            Q_i, v_i = normal_force(inner, d_i, -v), -v
        peak = max(peak, max(Q_o, Q_i))
        d_o, d_i = max(d_o, 0.0), max(d_i, 0.0)
        K = stiffness_bound(outer, d_o, v_o) + stiffness_bound(inner, d_i, v_i)
        C = damping_bound(outer, d_o, v_o) + damping_bound(inner, d_i, v_i)
        h = min(h_max, PERIOD_STEP * sqrt(m / max(K, 1e-300)))
        # implicit, because dashpots may be stiff
        v += h * (Q_i - Q_o + balance - h * K * v) / (m + h * (C + h * K))
        x += h * v
        t += h
    return peak


INITIAL_APPROACH = 1e-15  # m, initial approach of an impact; above 0, so that damping forces that jump act
LONGEST_IMPACT_STEP = 1e-7  # s, largest step of an impact
IMPACT_STEP = 0.2  # largest step of an impact, in units of m/C, the decay time of the speed under damping alone


@jit
def free_impact(m, law, speed, cpu_end):
    """Compute the impact of a free roller of mass ``m`` (kg) on one race with ``speed`` (m/s).

    cpu_end: CPU time (s) of the thread at which the computation stops (``cpu_time.bounded``). Returns the peak
    force (N) and the largest stiffness (N/m) and damping (N s/m) until the roller is at rest.
    """
    h_max = min(LONGEST_IMPACT_STEP, 1e-3 * pi * sqrt(m / stiffness_bound(law, 1e-7, 0.0)))
    delta, v, peak, K, C = INITIAL_APPROACH, speed, 0.0, 0.0, 0.0
    n = 0
    while v > 0.0 and not (n % STEPS_PER_CHECK == STEPS_PER_CHECK - 1 and is_over(cpu_end)):
        n += 1
        peak = max(peak, normal_force(law, delta, v))
        damping = damping_bound(law, delta, v)
        K, C = max(K, stiffness_bound(law, delta, v)), max(C, damping)
        h = min(h_max, IMPACT_STEP * m / damping) if damping > 0.0 else h_max
        delta += h * v
        v -= h * normal_force(law, delta, v) / m
    return peak, K, C
