"""Error due to the initial transient with `settle: auto`, compared with `error.start`.

    python -m benchmarks.start [--cases 40] [--seed 1] [--csv docs/data/start.csv]

Random scenes have housings of 1 to 60 kg on brackets of 1e6 to 1e8 N/m, with bracket damping of 1 to 20 % of
critical. Line, RMS and largest force are compared with a full run from static equilibrium with the same step and
ten times the settling time. An error must be at most `error.start` or 0.1 %; if neither record is periodic, so
that they differ at random, at most two combined errors.
"""

import random
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from math import hypot, sqrt
from typing import Any, NamedTuple

from bearingsim.config import Case
from bearingsim.simulation import settling, simulate
from bearingsim.simulation.comparison import fault_lines
from bearingsim.simulation.record import Record
from bearingsim.simulation.settling import SteadyExtrapolation
from benchmarks.campaign import table

SETTLE_FACTOR = 10.0  # times the settling time, for the other run
MAX_ERROR = 1e-3  # relative error of line and RMS, after settling
REPORTED_ERROR = 0.01  # relative error above which it must be stated
ERROR_MULTIPLE = 2.0  # combined errors, allowed if both records are random
MIN_PASSED = 0.95


class SceneResult(NamedTuple):
    """Result of a scene: settling time (s), ball passes computed, errors and stated errors, CPU times (s)."""

    scene: str
    model: str
    decay: float
    settle: float
    passes: int
    repeats: bool
    line: float
    said_line: float
    rms: float
    said_rms: float
    force: float
    said_force: float
    cpu: float
    cpu_long: float
    held: bool
    unsaid: bool


def scene(rng: random.Random) -> dict[str, Any]:
    """Draw the fields of a case."""
    mass, stiffness = 60.0 ** rng.random(), 1e6 * 100.0 ** rng.random()
    damping = 0.01 * 20.0 ** rng.random()
    width = rng.uniform(0.3, 1.0)
    race = "inner" if rng.random() < 0.15 else "outer"
    model = rng.choices(("rollers", "ring", "planar"), (7, 2, 1))[0]
    return {
        "bearing": rng.choice(("nf308", "nu206")),
        "model": model,
        "speed": f"{rng.uniform(900, 3000):.0f} rpm",
        "load": f"{rng.uniform(100, 600):.0f} N",
        "clearance": f"{rng.uniform(0, 20):.1f} um",
        "rig": {
            "ring_mass": f"{mass:.2f} kg",
            "bracket_stiffness": f"{stiffness:.3g} N/m",
            "bracket_damping": 2.0 * damping * sqrt(stiffness * mass),
        },
        "defect": {
            "race": race,
            "shape": "rectangular",
            "length": "8 mm",
            "width": f"{width:.2f} mm",
            "depth": "0.05 mm",
            "angle": f"{rng.uniform(-20, 20):.0f} deg",
        },
        "duration": "1 s" if model == "planar" else "0.5 s",
        "step_check": False,
    }


@contextmanager
def from_rest() -> Iterator[None]:
    """Start runs from static equilibrium, without the treatment of slow modes."""
    original = SteadyExtrapolation.from_case
    SteadyExtrapolation.from_case = classmethod(lambda *_: None)  # type: ignore[method-assign, assignment]
    try:
        yield
    finally:
        SteadyExtrapolation.from_case = original  # type: ignore[method-assign]


def compare_starts(fields: dict[str, Any]) -> SceneResult:
    """Compute a scene with `settle: auto` and from static equilibrium, and compare."""
    case = Case.model_validate(fields)
    record = simulate(case)
    settings = {"method": record.info["method"], "step": record.info["step_s"], "periodic": False}
    settle = float(record.info["settle_s"])
    with from_rest():
        long = simulate(case.model_copy(update=settings | {"settle": SETTLE_FACTOR * settle}))
    names = {f"velocity@{fault_lines(case)[0]}": "", "velocity.rms": ".rms", "outer_force.max": ".force"}
    errors = {name: abs(record.features[name] / long.features[name] - 1.0) for name in names}
    stated = {name: record.features[f"error.start{suffix}"] for name, suffix in names.items()}
    bounds = {name: bound(record, long, f"error.start{suffix}") for name, suffix in names.items()}
    rig = fields["rig"]
    line, rms, force = names
    name = f"{fields['bearing']} {rig['ring_mass']} {rig['bracket_stiffness']}"
    return SceneResult(
        f"{name} {fields['load']} {fields['clearance']}",
        case.model,
        settling.slowest_decay(case),
        settle,
        int(record.info["passes_computed"]),
        float(record.info["period_passes"]) > 0,
        errors[line],
        stated[line],
        errors[rms],
        stated[rms],
        errors[force],
        stated[force],
        float(record.info["cpu_s"]),
        float(long.info["cpu_s"]),
        all(errors[name] <= max(MAX_ERROR, bounds[name]) for name in names),
        any(errors[name] > max(REPORTED_ERROR, bounds[name]) for name in names),
    )


def bound(record: Record, long: Record, name: str) -> float:
    """Return the bound of an error, including random differences if neither record is periodic."""
    if float(record.info["period_passes"]) > 0:
        return record.features[name]
    return max(record.features[name], ERROR_MULTIPLE * hypot(record.features[name], long.features[name]))


def main() -> None:
    """Measure all scenes and write the table. Exit code 1 if too few errors are within their bounds."""
    frame = table(__doc__, 40, scene, compare_starts)
    passed, unreported = int(frame["held"].sum()), int(frame["unsaid"].sum())
    counts = f"{passed} of {len(frame)} within their bounds, {unreported} over 1 % not stated"
    print(f"{counts}; {frame['repeats'].sum()} periodic")
    sys.exit(int(passed < MIN_PASSED * len(frame) or unreported > 0))


if __name__ == "__main__":
    main()
