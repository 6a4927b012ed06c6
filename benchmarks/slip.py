"""Slip of the cage against load and speed: simulated, and from a balance of forces (docs/slip.md).

    python benchmarks/slip.py RESULTS [--csv FILE] [--png FILE] [--onsets FILE]

RESULTS: of `bearingsim run studies/slip.yaml`. The onset of gross slip (the load at which the cage lags by 5 %,
coming from rolling) is bisected for each friction law and speed, three seeds each; about 4 CPU minutes.
"""

import argparse
from collections.abc import Callable
from math import exp, log, pi
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from scipy.optimize import brentq

from bearingsim import assemble, load_study, open_results, simulate
from bearingsim.config import Case
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.layout import Q_I, Q_O
from bearingsim.core.models.equilibrium import find_rest, rest_from_scratch
from bearingsim.core.parts.cage import land_drag, orbit_drag
from bearingsim.plots.style import COLOURS, MARKERS, RC

GROSS = 0.05  # slip of the cage from which it is called gross
CREEPING = np.geomspace(5e-4, GROSS, 200)  # slips that are tried in turn
CAGE_ANGLES = 16  # of a ball pass
SEEDS = (1, 2, 3)
SPEEDS = (600, 1800, 3000, 6000)  # rpm
LAWS = ("static-dynamic", "traction")


class Loads(NamedTuple):
    """Forces of the rollers at rest, all cage angles together: sums over the entries are means over a ball pass.

    angle: (n,) rad from the load line, in the sense of rotation; inner, outer: (n,) N.
    """

    angle: np.ndarray
    inner: np.ndarray
    outer: np.ndarray


def loads(model: Any, slip: float) -> Loads:
    """What each roller carries where, at the cage's speed with ``slip``."""
    b = model.bearing._replace(omega_c=model.bearing.omega_c * (1.0 - slip))
    still, y, entries = assemble.statics(model._replace(bearing=b)), assemble.empty_buffer(model), []
    for n in range(CAGE_ANGLES):
        turned = (n + 0.5) / CAGE_ANGLES * 2.0 * pi / b.Z
        (rest_from_scratch if n == 0 else find_rest)(still, turned / b.omega_c, y)
        angle = (b.theta_0 + turned + 2.0 * pi * np.arange(b.Z) / b.Z + pi) % (2.0 * pi) - pi
        entries.append([angle, y[Q_I : Q_I + b.Z] / CAGE_ANGLES, y[Q_O : Q_O + b.Z] / CAGE_ANGLES])
    return Loads(*np.concatenate(entries, axis=1))


def drag_torque(model: Any, slip: float) -> float:
    """Torque (N m) of the oil on cage and rollers."""
    b, r = model.bearing, 0.5 * (model.bearing.R_o + model.bearing.R_i)
    omega = b.omega_c * (1.0 - slip)
    return float(-land_drag(model.drag, omega, b.omega_i) - b.Z * r * orbit_drag(model.drag, omega * r))


def friction_torque(model: Any, found: Loads, slip: float) -> float:
    """Torque (N m) that the races can exert at a slip, through the rollers that have crossed their pockets."""
    r = 0.5 * (model.bearing.R_o + model.bearing.R_i)
    entry = found.angle[found.inner > 0.0].min()
    pushing = (found.inner > 0.0) & ((found.angle - entry) * r * slip >= 2.0 * model.cage.play)
    inner, outer = found.inner[pushing].sum(), found.outer[pushing].sum()
    return float(2.0 * r * coefficient(model, slip, inner / outer) * inner) if inner > 0.0 else 0.0


def coefficient(model: Any, slip: float, ratio: float) -> float:
    """Friction coefficient at the inner race, its force the same as at the outer: mu(v_i) Q_i = mu(v_o) Q_o.

    v_i + v_o = slip R_i omega_i; ratio: Q_i/Q_o.
    """
    b, ratio = model.bearing, min(ratio, 1.0 - 1e-9)
    v, u = slip * b.R_i * b.omega_i, b.R_w * b.omega_b
    v_o = brentq(lambda v_o: mu(model.friction, v - v_o, u) * ratio - mu(model.friction, v_o, u), 0.0, v / 2.0)
    return mu(model.friction, v - v_o, u)


def balance(case: Case) -> float:
    """Slip of the cage at which friction first holds the drag; 1 if it never does."""
    model = assemble.model(case)
    found = loads(model, 0.0)
    for slip in CREEPING:
        if friction_torque(model, found, slip) >= drag_torque(model, slip):
            return float(slip)

    def excess(slip: float) -> float:
        return friction_torque(model, loads(model, slip), slip) - drag_torque(model, slip)

    if excess(GROSS) >= 0.0:  # with its own loads: the slip that was tried last, to the step
        return GROSS
    return float(brentq(excess, GROSS, 0.99, xtol=1e-4)) if excess(0.99) > 0.0 else 1.0


def bisected(slip: Callable[[float], float], low: float, high: float) -> float:
    """Load (N) between ``low`` (gross slip) and ``high`` (none) at which gross slip sets in, to 1 %; or nan."""
    if not slip(low) > GROSS > slip(high):
        return float("nan")
    while high / low > 1.01:
        middle = exp(0.5 * (log(low) + log(high)))
        low, high = (middle, high) if slip(middle) > GROSS else (low, middle)
    return float((low * high) ** 0.5)


def onset_by_balance(case: Case, low: float = 0.2, high: float = 200.0) -> float:
    """Load (N) under which a case slips grossly, by the balance."""
    return bisected(lambda load: balance(case.model_copy(update={"load": load})), low, high)


def onset_by_simulation(case: Case, about: float) -> float:
    """The same by simulation from rolling, looked for within a factor of 1.5 of a load (N)."""
    near = (about / 1.5, 1.5 * about)
    return bisected(
        lambda load: simulate(case.model_copy(update={"load": load})).features["cage.slip.mean"], *near
    )


def onsets(base: Case) -> list[dict[str, Any]]:
    """Onset of gross slip for each law and speed, by both ways; and slip over load by the balance, to be drawn."""
    rows: list[dict[str, Any]] = []
    for law in LAWS:
        for speed in SPEEDS:
            case = Case.model_validate(given(base) | {"friction": law, "speed": speed * pi / 30.0})
            balanced = onset_by_balance(case)
            found = [onset_by_simulation(case.model_copy(update={"seed": seed}), balanced) for seed in SEEDS]
            rows.append({"friction": law, "speed_rpm": speed, "balance_N": round(balanced, 2)})
            rows[-1] |= {f"seed_{seed}_N": round(one, 2) for seed, one in zip(SEEDS, found, strict=True)}
            rows[-1]["simulated_over_balance"] = round(float(np.mean(found)) / balanced, 3)
            print(rows[-1], flush=True)
            near = np.concatenate([np.geomspace(1.0, 300.0, 40), balanced * np.array([0.98, 0.995, 1.005, 1.02])])
            near.sort()
            rows[-1]["curve"] = [near, [balance(case.model_copy(update={"load": float(load)})) for load in near]]
    return rows


def chart(folder: str, base: Case) -> pd.DataFrame:
    """One row for each law, speed and load: mean over the seeds, their range, unsteadiness, balance."""
    table = open_results(folder).table()
    grouped = table.groupby(["friction", "speed", "load"], sort=False)
    found = grouped["cage.slip.mean"].agg(slip="mean", least="min", most="max")
    found["std_in_time"] = grouped["cage.slip.std"].max()
    found["balance"] = [
        balance(Case.model_validate(given(base) | {"friction": law, "speed": speed, "load": load}))
        for law, speed, load in found.index
    ]
    found = found.reset_index()
    found["speed"] = (found["speed"] * 30.0 / pi).round()
    return found.rename(columns={"speed": "speed_rpm", "load": "load_N"}).round(5)


def given(case: Case) -> dict[str, Any]:
    """What was said of a case, to be said again with changes."""
    return case.model_dump(exclude_unset=True)


def draw(found: pd.DataFrame, at: list[dict[str, Any]], target: str) -> None:
    """The chart: simulated (markers, bars over the seeds) and by the balance (lines)."""
    with plt.rc_context(RC):
        figure, panels = plt.subplots(1, len(LAWS), figsize=(7.0, 3.4), sharey=True, layout="constrained")
        for axes, law in zip(panels, LAWS, strict=True):
            draw_law(axes, found[found["friction"] == law], [row for row in at if row["friction"] == law])
            axes.set(
                title=law, xlabel="load (N)", xscale="log", yscale="log", ylim=(0.1, 110.0), xlim=(0.9, 360.0)
            )
        panels[0].set_ylabel("slip of the cage (%)")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper", title="lines: balance")
        figure.savefig(target)


def draw_law(axes: Any, found: pd.DataFrame, at: list[dict[str, Any]]) -> None:
    """One panel."""
    for speed, colour, marker in zip(SPEEDS, COLOURS, MARKERS, strict=False):
        part = found[found["speed_rpm"] == speed]
        spread = 100.0 * np.abs(part[["least", "most"]].to_numpy().T - part["slip"].to_numpy())
        axes.errorbar(part["load_N"], 100.0 * part["slip"], spread, fmt=marker, color=colour, ms=4.5, capsize=2)
        axes.plot([], [], color=colour, marker=marker, ms=4.5, label=f"{speed} rpm")
        curve = np.array(next(row["curve"] for row in at if row["speed_rpm"] == speed))
        axes.plot(curve[0], 100.0 * curve[1], color=colour, lw=1.0)


def main() -> None:
    """Compare the results of the study with the balance; find the onsets; write tables and figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results")
    parser.add_argument("--csv", default="docs/data/slip.csv")
    parser.add_argument("--onsets", default="docs/data/slip_onset.csv")
    parser.add_argument("--png", default="docs/figures/slip.png")
    options = parser.parse_args()
    base = load_study("studies/slip.yaml").cases()[0]
    at = onsets(base)
    found = chart(options.results, base)
    found.to_csv(options.csv, index=False, lineterminator="\n")
    draw(found, at, options.png)
    pd.DataFrame(at).drop(columns="curve").to_csv(options.onsets, index=False, lineterminator="\n")


if __name__ == "__main__":
    main()
