"""Cost of the method chosen by `auto`, compared with all applicable methods and steps, for ten scenes.

    python -m benchmarks.choice [--scene NAME] [--each]

Five scenes are periodic, five are not. The reference is the Verlet method at 1/32 of the step limit at impact. (At
1/16 its own error, 2e-4 in `ring`, was mistaken for that of `auto`.) The error is the largest relative error of
defect line, RMS and largest force. Printed for each scene: method, error and CPU time (s, time steps only) of
`auto`; then, with the ratio of the two times,

surely    the cheapest run of a method from which on all its finer runs have no larger error
luckily   the cheapest run with no larger error, even if finer runs of its method have one
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
STEP_FRACTIONS = [4.0 * 2.0 ** (-n / 2) for n in range(13)]  # fractions of the step limit at impact
TOLERANCES = [1e-3 * 10.0 ** (-n / 2) for n in range(13)]
REFERENCE_FRACTION = 1.0 / 32.0
MAX_COST_RATIO = 3.0  # times the CPU time of `auto`, above which finer settings are not tried


class Run(NamedTuple):
    """Run of a scene: name, features, CPU time of its steps (s)."""

    name: str
    features: dict[str, float]
    cpu: float


NO_RUN = Run(f"none under {MAX_COST_RATIO:g} times", {}, inf)


def scene(fields: dict[str, Any]) -> Case:
    """Return a case of the NF308 at 1800 rpm and 150 N, 0.3 s long."""
    defaults = {"bearing": "nf308", "speed": 1800.0 * 3.14159265 / 30.0, "load": 150.0, "duration": 0.3}
    return Case.model_validate(defaults | {"defects": [SLOT], "record": []} | fields)


def run(case: Case, name: str) -> Run:
    """Compute a case twice, because the first run compiles; return the second."""
    simulate(case)
    record = simulate(case)
    return Run(name, record.features, float(record.info["integrator_cpu_s"]))


def manual_runs(case: Case, max_cpu: float) -> Iterator[Run]:
    """Yield runs of all applicable methods, from coarse to fine, until one takes more than ``max_cpu`` s."""
    for name, method in METHODS.items():
        if not choice.is_suitable(case, name):
            continue
        method_case = choice.with_method(case, name)
        step = choice.limits(method_case).at_impact
        for fraction, tolerance in zip(STEP_FRACTIONS, TOLERANCES, strict=True):
            setting = {"tolerance": tolerance} if method.adaptive else {"step": fraction * step}
            try:
                result = run(
                    method_case.model_copy(update=setting | {"step_check": False}),
                    f"{name} {next(iter(setting.values())):.2g}",
                )
            except SimulationError:
                continue
            yield result
            if result.cpu > max_cpu:
                break


def error(case: Case, result: Run, reference: Run) -> float:
    """Return the largest relative error of line, RMS and largest force."""
    names = [*(f"velocity@{line}" for line in fault_lines(case)), "velocity.rms", "outer_force.max"]
    return max(abs(result.features[name] / reference.features[name] - 1.0) for name in names)


def summary(name: str, case: Case, each: bool) -> str:
    """Return the printed line of a scene."""
    auto = run(case, "auto")
    method = str(simulate(case).info["method"])
    verlet = choice.with_method(case, "verlet")
    step = REFERENCE_FRACTION * choice.limits(verlet).at_impact
    reference = run(verlet.model_copy(update={"step": step, "step_check": False}), "reference")
    auto_error = error(case, auto, reference)
    within: dict[str, list[Run]] = {}
    sure: dict[str, list[Run]] = {}
    for candidate in manual_runs(case, MAX_COST_RATIO * auto.cpu):
        candidate_method, candidate_error = candidate.name.split()[0], error(case, candidate, reference)
        if each:
            print(f"    {candidate.name:32} {candidate_error:.1e} {candidate.cpu:.4f} s")
        if candidate_error <= auto_error:
            within.setdefault(candidate_method, []).append(candidate)
            sure.setdefault(candidate_method, []).append(candidate)
        else:
            sure[candidate_method] = []
    texts = [f"{name:26} {method:16} {auto_error:.1e} {auto.cpu:.4f} s"]
    for word, runs in (("surely", sure), ("luckily", within)):
        best = min(
            (run for of_method in runs.values() for run in of_method), key=lambda run: run.cpu, default=NO_RUN
        )
        texts.append(f"{word} {best.name:24} {best.cpu:.4f} s {auto.cpu / best.cpu:.2f}")
    return "; ".join(texts)


def main() -> None:
    """Print a line per scene."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", action="append", choices=list(SCENES))
    parser.add_argument("--each", action="store_true", help="a line for each run")
    options = parser.parse_args()
    for name in options.scene or SCENES:
        print(summary(name, scene(SCENES[name]), options.each), flush=True)


if __name__ == "__main__":
    main()
