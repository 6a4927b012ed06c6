"""Flexible outer ring: effect of harmonics, cap and step in random scenes, and cost of a step.

    python -m benchmarks.ring --harmonics 30 | --steps 50 | --chaos 11 | --cost [--seed 1] [--jobs 2]

harmonics  changes of line and RMS (below 10 kHz, sampled at 51.2 kHz) if harmonics and cap are doubled, relative
           to the largest defect contribution of the slot from 0 to 60 deg in static equilibrium, and to the RMS;
           for comparison, changes due to a displacement of the first roller by 0.001 deg (chaotic scatter)
steps      changes of line, RMS and largest force with half the step, compared with the stated step errors;
           number of refused scenes
chaos      original scenes, and variants with other damping, no clearance, no slot, a rigid ring: 1 if chaotic
cost       a Verlet step with 8, 20 and 40 harmonics, and in a housing, relative to a rigid ring
"""

import argparse
import cmath
import time
from collections.abc import Iterator
from math import pi
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from bearingsim import assemble
from bearingsim.assemble import bending, rest
from bearingsim.config import Case
from bearingsim.core.advance import RING_MOTION, Monitor, NoSamples, advance_and_sample, start_at_rest
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.equilibrium import solve_initial_equilibrium
from bearingsim.simulation import SimulationError, limits, simulate

DISPLACEMENT = 0.001 * pi / 180.0
SUPPORTS = ("point", "pads", "points", "housing")


def support(rng: np.random.Generator) -> dict[str, Any]:
    """Draw the load introduction of the ring."""
    by, angle = str(rng.choice(SUPPORTS)), float(rng.uniform(20.0, 70.0)) * pi / 180.0
    if by == "pads":
        return {"by": by, "angles": [-angle, angle]}
    if by == "points":
        k = float(10.0 ** rng.uniform(7.5, 9.5))
        return {"by": by, "at": [{"angle": -angle, "stiffness": k}, {"angle": angle, "stiffness": k}]}
    if by == "housing":
        fit = 1e-6 * float(rng.choice([0.0, rng.uniform(-15.0, 0.0), rng.uniform(0.0, 2.0)]))
        return {"by": by, "stiffness": float(10.0 ** rng.uniform(9.0, 12.0)), "fit": fit}
    return {"by": by}


def draw(number: int, seed: int, sampling: float) -> Case:
    """Draw a scene of `rollers`: NF308 with a slot and a flexible ring, harmonics `auto`."""
    rng = np.random.default_rng([seed, number])
    slot = {"shape": "rectangular", "length": 12e-3, "width": 1e-3 * float(rng.uniform(0.3, 2.0)), "depth": 50e-6}
    return Case.model_validate(
        {
            "bearing": "nf308",
            "speed": float(rng.uniform(900.0, 3000.0)) * pi / 30.0,
            "load": float(np.exp(rng.uniform(np.log(100.0), np.log(3000.0)))),
            "clearance": 1e-6 * float(rng.choice([0.0, rng.uniform(0.0, 15.0)])),
            "model": "rollers",
            "defects": [slot | {"angle": float(rng.uniform(0.0, 60.0)) * pi / 180.0}],
            "rig": {"ring": {"bends": True}, "load": support(rng)},
            "duration": 0.15,
            "sampling": sampling,
            "record": [],
        }
    )


def clear_caches() -> None:
    """Clear the caches of bearings."""
    caches = (
        bending.build_bending,
        assemble._build_model,
        rest._equilibrium,
        limits._common_limits,
        limits.load_and_rates_at_rest,
    )
    for cache in caches:
        cache.cache_clear()


def line(features: dict[str, float]) -> complex:
    """Return the complex velocity amplitude (m/s) at BPFO."""
    return cmath.rect(features["velocity@BPFO"], features["velocity@BPFO.phase"])


def with_harmonics(case: Case, times: int) -> Case:
    """Return the case with its harmonics multiplied."""
    assert case.rig.ring is not None
    more = case.rig.ring.model_copy(update={"harmonics": min(100, times * int(case.rig.ring.harmonics))})
    return case.model_copy(update={"rig": case.rig.model_copy(update={"ring": more})})


def subtract_healthy(case: Case) -> tuple[complex, float, dict[str, float]]:
    """Return the line minus that of the healthy bearing (m/s, complex), RMS (m/s), and all features."""
    features = simulate(case).features
    healthy = simulate(case.model_copy(update={"defects": ()})).features
    return line(features) - line(healthy), features["velocity.rms"], features


def largest_at_rest(case: Case) -> float:
    """Return the largest defect contribution (m/s) of `static` with the slot from 0 to 60 deg."""
    lines = []
    for angle in (0.0, 15.0, 30.0, 45.0, 60.0):
        slot = case.defects[0].model_copy(update={"angle": angle * pi / 180.0})
        static_case = case.model_copy(update={"model": "static", "method": None, "defects": (slot,)})
        lines.append(abs(subtract_healthy(static_case)[0]))
    return max(lines)


def compare_harmonics(number: int, seed: int) -> str:
    """Compare a scene with one of twice the harmonics and cap."""
    case = draw(number, seed, 51.2e3)
    cap = bending.MAX_FREQUENCY
    try:
        clear_caches()
        scale = largest_at_rest(case)
        base_line, rms, features = subtract_healthy(case)
        shifted, shifted_rms, _ = subtract_healthy(
            case.model_copy(update={"start_angle": case.start_angle + DISPLACEMENT})
        )
        bending.MAX_FREQUENCY = 2.0 * cap
        clear_caches()
        doubled_line, doubled_rms, doubled_features = subtract_healthy(with_harmonics(case, 2))
    except SimulationError as error:
        return f"{number:3} refused: {error}"
    finally:
        bending.MAX_FREQUENCY = cap
    scale = max(scale, abs(base_line))
    line_change, rms_change = abs(doubled_line - base_line) / scale, abs(doubled_rms / rms - 1.0)
    scatter = f"line {abs(shifted - base_line) / scale:.4f} rms {abs(shifted_rms / rms - 1.0):.4f}"
    stated = float(np.nanmax([features["step_error.line"], features["step_error.rms"]]))  # no line if chaotic
    suffix = " chaotic" * bool(features["chaotic"] or doubled_features["chaotic"])
    assert case.rig.load is not None
    text = f"{number:3} {case.rig.load.by:8} line {line_change:.4f} rms {rms_change:.4f} said {stated:.4f}"
    return f"{text}, displaced: {scatter}{suffix}"


def compare_steps(number: int, seed: int) -> str:
    """Compare a scene at its own step and at half of it."""
    case = draw(number, seed, 10240.0)
    try:
        record = simulate(case)
        step = 0.5 * float(record.info["step_s"])
        settings = {"method": str(record.info["method"]), "step_check": False}
        finer = simulate(case.model_copy(update=settings | {"step": step})).features
    except SimulationError as error:
        return f"{number:3} refused: {error}"
    prefix = "chaotic " * bool(record.features["chaotic"])
    return f"{number:3} {prefix}{record.info['method']} " + "; ".join(changes(record.features, finer))


def changes(features: dict[str, float], finer: dict[str, float]) -> Iterator[str]:
    """Yield the relative changes due to half the step, with the stated step errors."""
    for quantity, feature in (("line", "velocity@BPFO"), ("rms", "velocity.rms"), ("force", "outer_force.max")):
        change, size = abs(features[feature] - finer[feature]), finer[feature]
        if quantity == "line":
            change, size = abs(line(features) - line(finer)), max(size, 1e-3 * finer["velocity.rms"])
        stated = features[f"step_error.{quantity}"]
        yield f"{quantity} {change / size:.5f}/{stated:.5f}" + " OUT" * (change / size > stated)


def variants_of(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield the scene with one or two parameters changed."""
    base = case.model_dump()
    ring, contact = base["rig"]["ring"], base["contact"]
    damped = {"contact": contact | {"damping": {"law": "kraemer", "beta": 10e-6}}}
    variants: dict[str, dict[str, Any]] = {
        "as it is": {},
        "modal 3 %": {"rig": base["rig"] | {"ring": ring | {"damping": 0.03}}},
        "modal 10 %": {"rig": base["rig"] | {"ring": ring | {"damping": 0.1}}},
        "no clearance": {"clearance": 0.0},
        "contacts 10 us": damped,
        "contacts 10 us, no clearance": damped | {"clearance": 0.0},
        "no slot": {"defects": []},
        "rigid ring": {"rig": {}},
    }
    for name, fields in variants.items():
        yield name, Case.model_validate(base | fields)


def report_chaos(number: int, seed: int) -> str:
    """Report which variants of a scene are chaotic."""
    results = []
    for name, case in variants_of(draw(number, seed, 10240.0)):
        try:
            results.append(f"{name}: {simulate(case).features['chaotic']:.0f}")
        except SimulationError as error:
            results.append(f"{name}: {error}")
    return f"{number:3} " + "; ".join(results)


def cost() -> None:
    """Print the CPU time (ns) of a step."""
    base = {"bearing": "nf308", "speed": 188.5, "load": 150.0, "model": "rollers", "record": []}
    housing: dict[str, Any] = {"by": "housing", "stiffness": 1e10}
    rigs: dict[str, Any] = {"rigid": {}, **{f"to {n}": {"ring": {"harmonics": n}} for n in (8, 20, 40)}}
    rigs |= {
        "to 20, housing": {"ring": {"harmonics": 20}, "load": housing},
        "to 20, housing with a gap": {"ring": {"harmonics": 20}, "load": housing | {"fit": -5e-6}},
    }
    states = {}
    for name, rig in rigs.items():
        model = assemble.model(Case.model_validate(base | {"rig": rig}))
        y = assemble.empty_buffer(model)
        solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
        start_at_rest(model, 0.0, y)
        states[name] = (model, y)
    rows, out, best = np.array(RING_MOTION), np.empty((6, 20000)), dict.fromkeys(rigs, 1e9)
    for n in range(15):  # alternate between variants to average over disturbances
        for name, (model, y) in states.items():
            began = time.process_time()
            advance_and_sample(Verlet(2e-7), model, Monitor(8, 1.0), n * 20000, y, rows, out, NoSamples())
            best[name] = min(best[name], (time.process_time() - began) / 20000) if n else best[name]
    for name, seconds in best.items():
        print(f"{name:28} {1e9 * seconds:7.1f} ns {seconds / best['rigid']:6.2f}")


def main() -> None:
    """Run the requested comparisons."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--harmonics", type=int, default=0)
    parser.add_argument("--steps", type=int, default=0)
    parser.add_argument("--chaos", type=int, default=0)
    parser.add_argument("--cost", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    if not (options.cost or options.harmonics or options.steps or options.chaos):
        parser.error("nothing requested: --harmonics, --steps, --chaos or --cost")
    if options.cost:
        cost()
    for compare, count in (
        (compare_harmonics, options.harmonics),
        (compare_steps, options.steps),
        (report_chaos, options.chaos),
    ):
        scenes = Parallel(n_jobs=options.jobs, batch_size=1, return_as="generator")
        for text in scenes(delayed(compare)(n, options.seed) for n in range(count)):
            print(text, flush=True)


if __name__ == "__main__":
    main()
