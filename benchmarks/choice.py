"""Cost of the method chosen by `auto`, compared with all applicable methods and steps, for ten scenes.

    python benchmarks/choice.py [--scene NAME] [--each]

Five scenes are periodic, five are not. The reference is the Verlet method at 1/16 of the step limit at impact. The
error is the largest relative error of defect line, RMS and largest force. Printed for each scene: method, error
and CPU time (s, time steps only) of `auto`; the cheapest run with no larger error; the ratio of the two times.
"""

import argparse
from collections.abc import Iterator
from math import inf
from typing import Any, NamedTuple

from bearingsim.catalogue import METHODS
from bearingsim.config import Case
from bearingsim.simulation import SimulationError, choice, simulate
from bearingsim.simulation.comparison import fault_lines

SLOT = {"shape": "rectangular", "length": 0.012, "width": 0.8e-3, "depth": 50e-6}
CHI = {"damping": {"law": "hunt-crossley", "chi": 50.0}}
KINEMATIC = {"cage": {"motion": "kinematic"}}
INNER = {"defects": [SLOT | {"race": "inner"}]}
SCENES: dict[str, dict[str, Any]] = {
    "ring": {"model": "ring"},
    "rollers": {"model": "rollers"},
    "rollers, chi": {"model": "rollers", "contact": CHI},
    "rollers, bowl": {"model": "rollers", "defects": [SLOT | {"shape": "circular", "width": 2e-3}]},
    "planar": {"model": "planar"} | KINEMATIC,
    "ring, inner race": {"model": "ring"} | INNER,
    "rollers, inner race": {"model": "rollers"} | INNER,
    "rollers, inner race, chi": {"model": "rollers", "contact": CHI} | INNER,
    "ring, inner race, chi": {"model": "ring", "contact": CHI} | INNER,
    "planar, inner race": {"model": "planar"} | KINEMATIC | INNER,
}
PARTS = [4.0 * 2.0 ** (-n / 2) for n in range(13)]  # fractions of the step limit at impact
TOLERANCES = [1e-3 * 10.0 ** (-n / 2) for n in range(13)]
FINE = 1.0 / 16.0
SLOWEST = 3.0  # times the CPU time of `auto`, above which finer settings are not tried


class Run(NamedTuple):
    """Run of a scene: name, features, CPU time of its steps (s)."""

    name: str
    features: dict[str, float]
    cpu: float


def scene(fields: dict[str, Any]) -> Case:
    """Return a case of the NF308 at 1800 rpm and 150 N, 0.3 s long."""
    usual = {"bearing": "nf308", "speed": 1800.0 * 3.14159265 / 30.0, "load": 150.0, "duration": 0.3}
    return Case.model_validate(usual | {"defects": [SLOT], "record": []} | fields)


def run(case: Case, name: str) -> Run:
    """Compute a case twice, because the first run compiles; return the second."""
    simulate(case)
    record = simulate(case)
    return Run(name, record.features, float(record.info["integrator_cpu_s"]))


def by_hand(case: Case, most: float) -> Iterator[Run]:
    """Yield runs of all applicable methods, from coarse to fine, until one takes more than ``most`` s."""
    for name, method in METHODS.items():
        if not choice.can_step(case, name):
            continue
        named = choice.with_method(case, name)
        step = choice.limits(named).at_impact
        for part, tolerance in zip(PARTS, TOLERANCES, strict=True):
            given = {"tolerance": tolerance} if method.adaptive else {"step": part * step}
            try:
                found = run(
                    named.model_copy(update=given | {"step_check": False}),
                    f"{name} {next(iter(given.values())):.2g}",
                )
            except SimulationError:
                continue
            yield found
            if found.cpu > most:
                break


def error(case: Case, found: Run, right: Run) -> float:
    """Return the largest relative error of line, RMS and largest force."""
    names = [*(f"velocity@{line}" for line in fault_lines(case)), "velocity.rms", "outer_force.max"]
    return max(abs(found.features[name] / right.features[name] - 1.0) for name in names)


def told(name: str, case: Case, each: bool) -> str:
    """Return the printed line of a scene."""
    auto = run(case, "auto")
    method = str(simulate(case).info["method"])
    exact = choice.with_method(case, "verlet")
    step = FINE * choice.limits(exact).at_impact
    right = run(exact.model_copy(update={"step": step, "step_check": False}), "reference")
    most, best = error(case, auto, right), Run("none", {}, inf)
    for other in by_hand(case, SLOWEST * auto.cpu):
        off = error(case, other, right)
        if each:
            print(f"    {other.name:32} {off:.1e} {other.cpu:.4f} s")
        if off <= most and other.cpu < best.cpu:
            best = other
    ours, cheapest = f"{method:16} {most:.1e} {auto.cpu:.4f} s", f"{best.name:28} {best.cpu:.4f} s"
    return f"{name:26} {ours}; {cheapest}; {auto.cpu / best.cpu:.2f}"


def main() -> None:
    """Print a line per scene."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--scene", action="append", choices=list(SCENES))
    asked.add_argument("--each", action="store_true", help="a line for each run")
    given = asked.parse_args()
    for name in given.scene or SCENES:
        print(told(name, scene(SCENES[name]), given.each), flush=True)


if __name__ == "__main__":
    main()
