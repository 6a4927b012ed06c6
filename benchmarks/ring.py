"""Flexible outer ring: effect of harmonics, cap and step in random scenes, and cost of a step.

    python benchmarks/ring.py [--seed 1] [--harmonics 30] [--steps 50] [--chaos 11] [--cost] [--jobs 2]

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

DISPLACED = 0.001 * pi / 180.0
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


def forget() -> None:
    """Clear the caches of bearings."""
    caches = (bending.made, assemble._made_by_field, rest._rest, limits._without_method, limits.loads_at_rest)
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


def less_healthy(case: Case) -> tuple[complex, float, dict[str, float]]:
    """Return the line minus that of the healthy bearing (m/s, complex), RMS (m/s), and all features."""
    found = simulate(case).features
    healthy = simulate(case.model_copy(update={"defects": ()})).features
    return line(found) - line(healthy), found["velocity.rms"], found


def largest_at_rest(case: Case) -> float:
    """Return the largest defect contribution (m/s) of `static` with the slot from 0 to 60 deg."""
    lines = []
    for angle in (0.0, 15.0, 30.0, 45.0, 60.0):
        slot = case.defects[0].model_copy(update={"angle": angle * pi / 180.0})
        still = case.model_copy(update={"model": "static", "method": None, "defects": (slot,)})
        lines.append(abs(less_healthy(still)[0]))
    return max(lines)


def doubled(number: int, seed: int) -> str:
    """Compare a scene with one of twice the harmonics and cap."""
    case = draw(number, seed, 51.2e3)
    cap = bending.CAP
    try:
        forget()
        scale = largest_at_rest(case)
        once, rms, told = less_healthy(case)
        again, rms_again, _ = less_healthy(case.model_copy(update={"start_angle": case.start_angle + DISPLACED}))
        bending.CAP = 2.0 * cap
        forget()
        twice, rms_twice, told_twice = less_healthy(with_harmonics(case, 2))
    except SimulationError as error:
        return f"{number:3} refused: {error}"
    finally:
        bending.CAP = cap
    scale = max(scale, abs(once))
    of_line, of_rms = abs(twice - once) / scale, abs(rms_twice / rms - 1.0)
    displaced = f"line {abs(again - once) / scale:.4f} rms {abs(rms_again / rms - 1.0):.4f}"
    said = max(told["step_error.line"], told["step_error.rms"])
    chaotic = " chaotic" * bool(told["chaotic"] or told_twice["chaotic"])
    assert case.rig.load is not None
    told_of = f"{number:3} {case.rig.load.by:8} line {of_line:.4f} rms {of_rms:.4f} said {said:.4f}"
    return f"{told_of}, displaced: {displaced}{chaotic}"


def halved(number: int, seed: int) -> str:
    """Compare a scene at its own step and at half of it."""
    case = draw(number, seed, 10240.0)
    try:
        told = simulate(case)
        step = 0.5 * float(told.info["step_s"])
        named = {"method": str(told.info["method"]), "step_check": False}
        finer = simulate(case.model_copy(update=named | {"step": step})).features
    except SimulationError as error:
        return f"{number:3} refused: {error}"
    chaotic = "chaotic " * bool(told.features["chaotic"])
    return f"{number:3} {chaotic}{told.info['method']} " + "; ".join(changes(told.features, finer))


def changes(told: dict[str, float], finer: dict[str, float]) -> Iterator[str]:
    """Yield the relative changes due to half the step, with the stated step errors."""
    for what, feature in (("line", "velocity@BPFO"), ("rms", "velocity.rms"), ("force", "outer_force.max")):
        change, size = abs(told[feature] - finer[feature]), finer[feature]
        if what == "line":
            change, size = abs(line(told) - line(finer)), max(size, 1e-3 * finer["velocity.rms"])
        said = told[f"step_error.{what}"]
        yield f"{what} {change / size:.5f}/{said:.5f}" + " OUT" * (change / size > said)


def varied(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield the scene with one or two parameters changed."""
    given = case.model_dump()
    ring, contact = given["rig"]["ring"], given["contact"]
    heavy = {"contact": contact | {"damping": {"law": "kraemer", "beta": 10e-6}}}
    changed: dict[str, dict[str, Any]] = {
        "as it is": {},
        "modal 3 %": {"rig": given["rig"] | {"ring": ring | {"damping": 0.03}}},
        "modal 10 %": {"rig": given["rig"] | {"ring": ring | {"damping": 0.1}}},
        "no clearance": {"clearance": 0.0},
        "contacts 10 us": heavy,
        "contacts 10 us, no clearance": heavy | {"clearance": 0.0},
        "no slot": {"defects": []},
        "rigid ring": {"rig": {}},
    }
    for name, fields in changed.items():
        yield name, Case.model_validate(given | fields)


def chaotic(number: int, seed: int) -> str:
    """Report which variants of a scene are chaotic."""
    found = []
    for name, case in varied(draw(number, seed, 10240.0)):
        try:
            found.append(f"{name}: {simulate(case).features['chaotic']:.0f}")
        except SimulationError as error:
            found.append(f"{name}: {error}")
    return f"{number:3} " + "; ".join(found)


def cost() -> None:
    """Print the CPU time (ns) of a step."""
    base = {"bearing": "nf308", "speed": 188.5, "load": 150.0, "model": "rollers", "record": []}
    housing: dict[str, Any] = {"by": "housing", "stiffness": 1e10}
    rigs: dict[str, Any] = {"rigid": {}, **{f"to {n}": {"ring": {"harmonics": n}} for n in (8, 20, 40)}}
    rigs |= {
        "to 20, housing": {"ring": {"harmonics": 20}, "load": housing},
        "to 20, housing with a gap": {"ring": {"harmonics": 20}, "load": housing | {"fit": -5e-6}},
    }
    ready = {}
    for name, rig in rigs.items():
        model = assemble.model(Case.model_validate(base | {"rig": rig}))
        y = assemble.empty_buffer(model)
        solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
        start_at_rest(model, 0.0, y)
        ready[name] = (model, y)
    places, out, best = np.array(RING_MOTION), np.empty((6, 20000)), dict.fromkeys(rigs, 1e9)
    for n in range(15):  # alternate between variants to average over disturbances
        for name, (model, y) in ready.items():
            began = time.process_time()
            advance_and_sample(Verlet(2e-7), model, Monitor(8, 1.0), n * 20000, y, places, out, NoSamples())
            best[name] = min(best[name], (time.process_time() - began) / 20000) if n else best[name]
    for name, took in best.items():
        print(f"{name:28} {1e9 * took:7.1f} ns {took / best['rigid']:6.2f}")


def main() -> None:
    """Run the requested comparisons."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--harmonics", type=int, default=0)
    asked.add_argument("--steps", type=int, default=0)
    asked.add_argument("--chaos", type=int, default=0)
    asked.add_argument("--cost", action="store_true")
    asked.add_argument("--jobs", type=int, default=2)
    given = asked.parse_args()
    if given.cost:
        cost()
    for what, count in ((doubled, given.harmonics), (halved, given.steps), (chaotic, given.chaos)):
        scenes = Parallel(n_jobs=given.jobs, batch_size=1, return_as="generator")
        for told in scenes(delayed(what)(n, given.seed) for n in range(count)):
            print(told, flush=True)


if __name__ == "__main__":
    main()
