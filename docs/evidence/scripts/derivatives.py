"""What it costs an implicit method to take ``planar``'s derivatives by differences, as ``spatial``'s are.

    python docs/evidence/scripts/derivatives.py [--csv FILE]

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
from statistics import median
from typing import Any

import own_cache  # noqa: F401  (before the core)

from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.models.differences import accelerate_bodies, fill_difference_jacobian, is_free_coordinate
from bearingsim.core.models.interface import linearise
from bearingsim.core.models.outer_ring import accelerate_outer_ring
from bearingsim.core.models.planar import Planar
from bearingsim.core.parts.cage import accelerate_cage, cage_constraint
from bearingsim.core.parts.shaft import accelerate_inner_ring, accelerate_ring_rotation
from bearingsim.simulation import choice
from bearingsim.simulation.integration import integrate, step_usage
from bearingsim.simulation.run_setup import set_up

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
    accelerate_bodies.register(Planar)(_accelerate_bodies)
    is_free_coordinate.register(Planar)(lambda model, i: i == 0 or cage_constraint(model.cage, 1.0) > 0.0)
    linearise.register(Planar)(lambda model, t, y: fill_difference_jacobian(model, t, y))


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
        setup, before = set_up(choice.resolve(case)), step_usage().cpu_s
        raw = integrate(setup)
        found.append((step_usage().cpu_s - before, int(raw.y[lay.STEPS_TAKEN]), float(raw.fine[2].std())))
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
