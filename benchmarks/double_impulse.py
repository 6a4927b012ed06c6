"""Entry and impact positions of a rolling element that crosses a wide defect (docs/double_impulse.md).

    python -m benchmarks.double_impulse [--csv FILE]

Events are detected in the contact forces. Their spacing is also determined from the motion of the ring, as from a
measured signal (`signals.entry_to_exit_time`). About 2 minutes of CPU time.
"""

import argparse
from collections.abc import Iterator
from itertools import product
from math import nan, pi, radians, sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.signals import entry_to_exit_time
from bearingsim.simulation.record import Record
from bearingsim.simulation.simulate import simulate
from benchmarks.rows import write_csv

OUTER_6205 = 0.02349  # m, radius of the outer race
ARCS = (5.0, 8.0)  # degrees of the outer race, as for the measured bearings
DEPTHS = (20e-6, 30e-6, 50e-6)  # m; unknown for the measured bearings
SPEEDS = (600, 900, 1200)  # rpm
ENTRY_FRACTION = 0.5  # of the force before the defect; the element has entered below it
IMPACT_FRACTION = 0.1  # of that force; the element has struck the far edge above it (but not the floor)
SEARCH_MARGIN = 1.1  # times the expected distance of the impact from the far rim, where the search begins
PASSES = 52  # ball passes of the record of the ring
COLUMNS = (
    "bearing",
    "width_mm",
    "depth_um",
    "rpm",
    "entry",
    "strike",
    "strike_by_geometry",
    "before_end_over_geometry",
    "spacing_ms",
    "crossing_ms",
    "ratio",
    "ratio_velocity",
    "ratio_acceleration",
)


class Crossing(NamedTuple):
    """Positions (m from the near rim) at which an element has entered the defect and strikes the far edge."""

    entry: float
    strike: float


CONTACT: dict[str, Any] = {"contact": {"damping": {"law": "hunt-crossley", "chi": "50 s/m"}}}
"""Contact law with a continuous force at impact, so that its rise can be detected."""


class Reading(NamedTuple):
    """Means over the crossings of a record: positions (m), their spacing and the whole crossing (s)."""

    entry: float
    strike: float
    spacing: float
    crossing: float


def scene(bearing: str, rpm: float, width: float, depth: float, passes: float = 5, **changes: Any) -> Case:
    """Return a case with a slot (m) over the track at phi = 0 and 150 N, with unfiltered outer forces."""
    base = {"bearing": bearing, "speed": rpm * pi / 30.0, "load": "150 N", "model": "rollers"} | CONTACT | changes
    b = Case.model_validate(base).bearing
    ball_pass = 1.0 / b.ball_pass_frequency(rpm * pi / 30.0)
    slot = {"shape": "rectangular", "width": width, "depth": depth, "length": b.roller_length or b.roller_diameter}
    record = {"sampling": "100 kHz", "antialias": False, "settle": 4 * ball_pass, "duration": passes * ball_pass}
    forces = [f"roller.{j + 1}.outer_force" for j in range(b.rollers)]
    return Case.model_validate(record | {"record": forces} | base | {"defect": slot})


def reach(case: Case) -> float:
    """Compute sqrt(2 R_eff d) (m), the distance from a rim at which an element on the floor touches it."""
    b = assemble.model(case).bearing
    return sqrt(2.0 * b.R_w * b.R_o / (b.R_o - b.R_w) * case.defects[0].depth)


def crossings(case: Case, record: Record) -> Iterator[Crossing]:
    """Yield all complete crossings of a record, from contact forces at kinematic cage speed."""
    b, width, x = assemble.model(case).bearing, case.defects[0].width, reach(case)
    for j in range(b.Z):
        angle = record.info["cage_angle_start_rad"] + b.omega_c * record.time + 2.0 * pi * j / b.Z
        along = b.R_o * ((angle - case.defects[0].angle + pi) % (2.0 * pi) - pi) + width / 2.0
        force = record.series[f"roller.{j + 1}.outer_force"]
        indices = np.flatnonzero((along > -0.15 * width) & (along < 1.15 * width))
        for group in np.split(indices, np.flatnonzero(np.diff(indices) > 1) + 1):
            if len(group) and along[group[0]] < -0.09 * width and along[group[-1]] > 1.09 * width:
                yield detect_events(along[group], force[group], width - SEARCH_MARGIN * x)


def detect_events(along: np.ndarray, force: np.ndarray, search_start: float) -> Crossing:
    """Detect the events of a crossing from positions (n,) in m and forces (n,) in N; ``edge`` precedes impact."""
    mean_force = force[along < 0.0].mean()
    entries = np.flatnonzero((along > 0.0) & (force < ENTRY_FRACTION * mean_force))
    impacts = np.flatnonzero((along >= search_start) & (force > IMPACT_FRACTION * mean_force))
    return Crossing(along[entries[0]] if len(entries) else nan, along[impacts[0]] if len(impacts) else nan)


def read(case: Case) -> Reading:
    """Simulate a case and average its crossings."""
    b = assemble.model(case).bearing
    entry, strike = np.mean(list(crossings(case, simulate(case))), axis=0)
    speed = b.R_o * b.omega_c
    return Reading(entry, strike, (strike - entry) / speed, case.defects[0].width / speed)


def spacing_of_ring(case: Case, quantity: str) -> float:
    """Determine the spacing (s) of the two impulses from the ring's ``velocity`` or ``acceleration``."""
    ball_pass = 1.0 / case.bearing.ball_pass_frequency(case.speed)
    changes = {
        "sampling": 51200.0,
        "antialias": True,
        "duration": PASSES * ball_pass,
        "record": (f"ring.{quantity}",),
    }
    series = getattr(simulate(case.model_copy(update=changes)), quantity)[:, 0]
    return entry_to_exit_time(series, 51200.0, ball_pass)


def rows() -> Iterator[dict[str, Any]]:
    """Yield the rows of the table: arcs of the 6205, slots of the NF308."""
    arcs = [("6205", radians(arc) * OUTER_6205, depth, rpm) for arc, depth, rpm in product(ARCS, DEPTHS, SPEEDS)]
    slots = [("nf308", width, 30e-6, rpm) for width, rpm in product((2e-3, 3e-3, 4e-3, 6e-3), (900, 1800))]
    for bearing, width, depth, rpm in [*arcs, *slots]:
        case = scene(bearing, rpm, width, depth)
        reading, x = read(case), reach(case)
        ratios = [spacing_of_ring(case, quantity) / reading.crossing for quantity in ("velocity", "acceleration")]
        positions = [reading.entry / width, reading.strike / width, 1.0 - x / width, (width - reading.strike) / x]
        times = [1e3 * reading.spacing, 1e3 * reading.crossing, reading.spacing / reading.crossing, *ratios]
        numbers = [round(float(value), 3) for value in [*positions, *times]]
        yield dict(zip(COLUMNS, [bearing, round(1e3 * width, 3), round(1e6 * depth), rpm, *numbers], strict=True))


def main() -> None:
    """Print the table, or write it to a file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--csv")
    options = parser.parse_args()
    write_csv(rows(), options.csv)


if __name__ == "__main__":
    main()
