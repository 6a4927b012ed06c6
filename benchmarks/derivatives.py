"""What it costs an implicit method to take ``planar``'s derivatives by differences, as ``spatial``'s are.

    python benchmarks/derivatives.py [--csv FILE]

CPU time of the integrator for 23 ms of the NF308 over a 0.8 mm slot (1800 rpm, 150 N), exact derivatives beside
differences: two processes a round, in turn, of which the shortest of three rounds counts. Contacts from soft to
stiff dampers, cages that slip and that do not, Rodas and backward Euler at two tolerances each. Also compared:
steps and RMS. The bracket does not let the ring rotate: its torque is not shared out here.
"""

import argparse
import csv
import json
import os
import subprocess
import sys
from itertools import product
from math import sqrt
from statistics import median
from typing import Any

import own_cache  # noqa: F401  (before the core)

from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.sides import InnerSide, OuterSide, contact_rows, normal_rows, sign
from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.models import planar
from bearingsim.core.models.differences import accelerate_bodies, difference_jacobian, roller_moves
from bearingsim.core.models.interface import accelerations, linearise
from bearingsim.core.models.outer_ring import accelerate_outer_ring
from bearingsim.core.models.planar import Planar
from bearingsim.core.parts.cage import FreeCage, accelerate_cage, cage_constraint, radial_stop
from bearingsim.core.parts.shaft import accelerate_inner_ring, accelerate_ring_rotation
from bearingsim.simulation import choice
from bearingsim.simulation.integration import integrate, set_up

ROUNDS = 3
SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
SHORT: dict[str, Any] = {
    "bearing": "nf308",
    "speed": "1800 rpm",
    "load": "150 N",
    "duration": "20 ms",
    "settle": "3 ms",
}
SHORT |= {"model": "planar", "defect": SLOT, "step_check": False}
CAGES: dict[str, dict[str, Any]] = {
    "kinematic": {"cage": {"motion": "kinematic"}},
    "free": {"friction": "traction"},
}
TOLERANCES = {"rodas": (1e-3, 1e-5), "backward-euler": (1e-2, 1e-3)}
COLUMNS = (
    "cage",
    "contact",
    "method",
    "tolerance",
    "exact_s",
    "differences_s",
    "ratio",
    "exact_steps",
    "differences_steps",
    "rms_change",
)


def general(exponent: float, coefficient: float) -> dict[str, Any]:
    """Damping of ``coefficient`` N (s/mm)/mm^exponent."""
    return {"law": "general", "coefficient": coefficient, "velocity_exponent": 1, "indentation_exponent": exponent}


CONTACTS: dict[str, Any] = {
    "chi = 50 s/m": {"chi": 50.0},
    "chi = 5000 s/m": {"chi": 5000.0},
    "m3 = 0, c = 1": general(0, 1.0),
    "m3 = 0, c = 1e2": general(0, 1e2),
    "m3 = 1, c = 1e4": general(1, 1e4),
    "m3 = 1, c = 1e6": general(1, 1e6),
}


# What differences need of ``planar``


@jit
def on_race(side, rub, y, j):
    """Force (N) of roller ``j`` on a race along e_0 and e_90, from its rows; rub: friction (N)."""
    force, _, _, _, tilt = contact_rows(side)
    normal, _, _, _, _ = normal_rows(side)
    n_r, n_t, lean = y[normal + j], y[normal + lay.ROW + j], y[tilt + j] / max(y[force + j], 1e-300)
    cosine = 1.0 / sqrt(1.0 + lean * lean)
    along, across = -sign(side) * (y[force + j] + rub * lean * cosine), y[tilt + j] - rub * cosine
    f_r, f_t, c, s = along * n_r - across * n_t, along * n_t + across * n_r, y[lay.COS + j], y[lay.SIN + j]
    return -f_r * c + f_t * s, -f_r * s - f_t * c


@jit
def pocket_force(cage, bearing, omega_cage, spin, y, j):
    """What a pocket does to roller ``j``, and the roller to the cage: forces (N), torques (N m).

    The first along the pocket's own directions, the other along e_0 and e_90. Written out as in ``parts/cage.py``:
    a loop there that calls such a function loses its lanes.
    """
    middle, R_w, real = 0.5 * (bearing.R_o + bearing.R_i), bearing.R_w, bearing.m_r * y[lay.INVERSE_MASS + j]
    x, z = y[lay.POSITION + lay.X_C], y[lay.POSITION + lay.Y_C]
    v_x, v_z = y[lay.VELOCITY + lay.X_C], y[lay.VELOCITY + lay.Y_C]
    pc, ps, ce, se = y[lay.COS_POCKET + j], y[lay.SIN_POCKET + j], y[lay.COS_EPS + j], y[lay.SIN_EPS + j]
    r, v = middle + y[lay.RADIAL + j], y[lay.RADIAL_V + j]
    w = r * (omega_cage + y[lay.EPS_V + j])
    e = r * se + x * ps - z * pc
    rho = r * ce - x * pc - z * ps
    v_r = v * ce - w * se - v_x * pc - v_z * ps  # of the roller less the cage's centre, in the pocket's frame
    v_t = v * se + w * ce + v_x * ps - v_z * pc
    side = 1.0 if e > 0.0 else -1.0
    N = normal_force(cage.pocket, abs(e) - cage.play, side * (v_t - omega_cage * rho))
    slip = v_r - side * R_w * (spin + y[lay.SPIN_V + j]) + omega_cage * (e + side * R_w)
    f = mu(cage.friction, slip, R_w * abs(spin)) * N
    stop = radial_stop(cage.guide, rho - middle, v_r + omega_cage * e)
    push_r, push_t, twist = real * (stop - f), -real * side * N, real * side * R_w * f
    on_cage = -push_r * pc + push_t * ps, -push_r * ps - push_t * pc, e * push_r - rho * push_t - twist
    return push_r, push_t, twist, on_cage


@generic(absent=None)
def share_pocket_loads(cage: Any, bearing: Any, omega_cage: float, spin: float, y: Any) -> None:
    """Fill the rows of what each roller does to the cage."""


@share_pocket_loads.register(FreeCage)
def _share_pocket_loads(cage, bearing, omega_cage, spin, y):
    for j in range(bearing.Z):
        _, _, _, (f_x, f_y, torque) = pocket_force(cage, bearing, omega_cage, spin, y, j)
        y[lay.roller_load(lay.F_X_C) + j], y[lay.roller_load(lay.F_Y_C) + j] = f_x, f_y
        y[lay.roller_load(lay.M_C) + j] = torque


exact_accelerations = jit(planar._accelerations)


def _accelerations(model, t, y):
    """Those of ``planar``, and what each roller does to rings and cage."""
    exact_accelerations(model, t, y)
    b = model.bearing
    _, rate, _ = kinematic_time(model.motion, t)
    omega_cage, spin = b.omega_c * rate + y[lay.VELOCITY + lay.PHI_C], (b.omega_c - b.omega_b) * rate
    for j in range(b.Z):
        f_x, f_y = on_race(OuterSide(), y[lay.FRICTION_O + j], y, j)
        y[lay.roller_load(lay.F_X) + j], y[lay.roller_load(lay.F_Y) + j] = f_x, f_y
        f_x, f_y = on_race(InnerSide(), y[lay.FRICTION_I + j], y, j)
        y[lay.roller_load(lay.F_X_I) + j], y[lay.roller_load(lay.F_Y_I) + j] = f_x, f_y
    share_pocket_loads(model.cage, model.bearing, omega_cage, spin, y)


def _accelerate_bodies(model, t, y):
    b = model.bearing
    time, rate, growth = kinematic_time(model.motion, t)
    omega_i, omega_cage = b.omega_i * rate, b.omega_c * rate + y[lay.VELOCITY + lay.PHI_C]
    alpha = accelerate_cage(model.cage, model, omega_cage, omega_i, b.omega_c * growth, y)
    y[lay.ACCELERATION + lay.PHI_C] = alpha - b.omega_c * growth
    accelerate_outer_ring(model, y)
    accelerate_ring_rotation(model.bracket, y)
    accelerate_inner_ring(model.shaft, model, b.omega_i * time, omega_i, b.omega_i * growth, y)


def take_differences() -> None:
    """From now on ``planar`` is derived by differences."""
    accelerations.register(Planar)(_accelerations)
    accelerate_bodies.register(Planar)(_accelerate_bodies)
    roller_moves.register(Planar)(lambda model, i: i == 0 or cage_constraint(model.cage, 1.0) > 0.0)
    linearise.register(Planar)(lambda model, t, y: difference_jacobian(model, t, y))


# The comparison


def runs() -> list[tuple[str, str, str, float]]:
    """Cage, contact, method, tolerance of every run."""
    return [(*way, m, tol) for way in product(CAGES, CONTACTS) for m, given in TOLERANCES.items() for tol in given]


def compute() -> list[tuple[float, int, float]]:
    """CPU seconds, steps and RMS of every run, in this process."""
    found = []
    for cage, contact, method, tolerance in runs():
        fields = SHORT | CAGES[cage] | {"contact": {"damping": CONTACTS[contact]}}
        case = Case.model_validate(fields | {"method": method, "tolerance": tolerance})
        raw = integrate(set_up(choice.resolved(case)))
        found.append((raw.integrator_cpu_s, int(raw.y[lay.STEPS_TAKEN]), float(raw.fine[2].std())))
    return found


def in_process(way: str) -> Any:
    """What ``compute`` finds in a process of its own, which keeps its compiled code apart."""
    kept = os.environ | {"BEARINGSIM_CACHE": f"{os.environ['BEARINGSIM_CACHE']}-{way}"}
    asked = [sys.executable, __file__, "--way", way]
    return json.loads(subprocess.run(asked, env=kept, stdout=subprocess.PIPE, check=True).stdout)


def main() -> None:
    """Compare, print and write a row for each run."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--csv", metavar="FILE")
    asked.add_argument("--way", choices=("exact", "differences"), help="one process of the comparison")
    given = asked.parse_args()
    if given.way:
        if given.way == "differences":
            take_differences()
        print(json.dumps(compute()))
        return
    rounds = [(in_process("exact"), in_process("differences")) for _ in range(ROUNDS)]
    rows = []
    for k, run in enumerate(runs()):
        exact, other = (min(one[way][k] for one in rounds) for way in (0, 1))
        ratio, changed = other[0] / exact[0], other[2] / exact[2] - 1.0
        rows.append(
            (*run, f"{exact[0]:.3g}", f"{other[0]:.3g}", f"{ratio:.2f}", exact[1], other[1], f"{changed:.1e}")
        )
    if given.csv:
        with open(given.csv, "w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])
    for row in rows:
        print(*row)
    print("median ratio", median(float(row[6]) for row in rows))


if __name__ == "__main__":
    main()
