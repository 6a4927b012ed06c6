"""Cage slip against load and speed, simulated and from an equilibrium of friction and drag (docs/slip.md).

    python -m benchmarks.slip RESULTS [--csv FILE] [--png FILE] [--onsets FILE]

RESULTS is the folder of `bearingsim run studies/slip.yaml`. The onset of gross slip (load at which the cage slip,
from initial rolling, is 5 %) is determined by bisection for each friction law and speed, for three seeds each.
About 4 minutes of CPU time.
"""

import argparse
from collections.abc import Callable
from math import exp, log, pi
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.lines import Line2D
from scipy.optimize import brentq

from bearingsim import assemble, load_study, open_results, simulate
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.models.equilibrium import solve_equilibrium, solve_initial_equilibrium
from bearingsim.core.parts.cage import land_drag, orbit_drag
from bearingsim.plots.style import COLOURS, MARKERS, RC
from bearingsim.plots.ticks import set_log_ticks

GROSS = 0.05  # minimum cage slip that counts as gross
SMALL_SLIPS = np.geomspace(5e-4, GROSS, 200)  # slips tried in turn
CAGE_ANGLES = 16  # number of cage angles over a ball pass
SEEDS = (1, 2, 3)
SPEEDS = (600, 1800, 3000, 6000)  # rpm
LAWS = ("static-dynamic", "traction")
STUDY = "studies/slip.yaml"


class Loads(NamedTuple):
    """Static roller forces at all cage angles, scaled so that sums over the entries are means over a ball pass.

    angle: (n,) rad from the load line, in the sense of rotation; inner, outer: (n,) N.
    """

    angle: np.ndarray
    inner: np.ndarray
    outer: np.ndarray


def loads(model: Any, slip: float) -> Loads:
    """Compute the roller forces and angles, with the cage speed reduced by ``slip``."""
    b = model.bearing._replace(omega_c=model.bearing.omega_c * (1.0 - slip))
    static, y, entries = assemble.static_model(model._replace(bearing=b)), assemble.empty_buffer(model), []
    for n in range(CAGE_ANGLES):
        cage_angle = (n + 0.5) / CAGE_ANGLES * 2.0 * pi / b.Z
        (solve_initial_equilibrium if n == 0 else solve_equilibrium)(static, cage_angle / b.omega_c, y)
        angle = (b.theta_0 + cage_angle + 2.0 * pi * np.arange(b.Z) / b.Z + pi) % (2.0 * pi) - pi
        entries.append([angle, y[lay.Q_I : lay.Q_I + b.Z] / CAGE_ANGLES, y[lay.Q_O : lay.Q_O + b.Z] / CAGE_ANGLES])
    return Loads(*np.concatenate(entries, axis=1))


def drag_torque(model: Any, slip: float) -> float:
    """Compute the drag torque (N m) of the oil on cage and rollers."""
    b, r = model.bearing, 0.5 * (model.bearing.R_o + model.bearing.R_i)
    omega = b.omega_c * (1.0 - slip)
    return float(-land_drag(model.drag, omega, b.omega_i) - b.Z * r * orbit_drag(model.drag, omega * r))


def friction_torque(model: Any, static_loads: Loads, slip: float) -> float:
    """Compute the torque (N m) available from the races at a slip, from rollers in contact with the cage."""
    r = 0.5 * (model.bearing.R_o + model.bearing.R_i)
    entry = static_loads.angle[static_loads.inner > 0.0].min()
    is_pushing = (static_loads.inner > 0.0) & ((static_loads.angle - entry) * r * slip >= 2.0 * model.cage.play)
    inner, outer = static_loads.inner[is_pushing].sum(), static_loads.outer[is_pushing].sum()
    return float(2.0 * r * coefficient(model, slip, inner / outer) * inner) if inner > 0.0 else 0.0


def coefficient(model: Any, slip: float, ratio: float) -> float:
    """Compute the friction coefficient at the inner race from equal friction at both: mu(v_i) Q_i = mu(v_o) Q_o.

    v_i + v_o = slip R_i omega_i; ratio: Q_i/Q_o.
    """
    b, ratio = model.bearing, min(ratio, 1.0 - 1e-9)
    v, u = slip * b.R_i * b.omega_i, b.R_w * b.omega_b
    v_o = brentq(lambda v_o: mu(model.friction, v - v_o, u) * ratio - mu(model.friction, v_o, u), 0.0, v / 2.0)
    return mu(model.friction, v - v_o, u)


def balance(case: Case) -> float:
    """Compute the smallest cage slip at which friction balances the drag; 1 if there is none."""
    model = assemble.model(case)
    static_loads = loads(model, 0.0)
    for slip in SMALL_SLIPS:
        if friction_torque(model, static_loads, slip) >= drag_torque(model, slip):
            return float(slip)

    def excess(slip: float) -> float:
        return friction_torque(model, loads(model, slip), slip) - drag_torque(model, slip)

    if excess(GROSS) >= 0.0:  # with loads at that slip; the last slip tried is accurate to its spacing
        return GROSS
    return float(brentq(excess, GROSS, 0.99, xtol=1e-4)) if excess(0.99) > 0.0 else 1.0


def bisect_onset(slip: Callable[[float], float], low: float, high: float) -> float:
    """Find the load (N) of onset of gross slip between ``low`` (slip) and ``high`` (none), to 1 %; or nan."""
    if not slip(low) > GROSS > slip(high):
        return float("nan")
    while high / low > 1.01:
        middle = exp(0.5 * (log(low) + log(high)))
        low, high = (middle, high) if slip(middle) > GROSS else (low, middle)
    return float((low * high) ** 0.5)


def onset_by_balance(case: Case, low: float = 0.2, high: float = 200.0) -> float:
    """Compute the load (N) below which a case has gross slip, from the balance."""
    return bisect_onset(lambda load: balance(case.model_copy(update={"load": load})), low, high)


def onset_by_simulation(case: Case, load_estimate: float) -> float:
    """Find the same load by simulation from rolling, within a factor of 1.5 of a load (N)."""
    limits = (load_estimate / 1.5, 1.5 * load_estimate)
    return bisect_onset(
        lambda load: simulate(case.model_copy(update={"load": load})).features["cage.slip.mean"], *limits
    )


def onsets(base: Case) -> list[dict[str, Any]]:
    """List the onset of gross slip for each law and speed by both methods."""
    rows: list[dict[str, Any]] = []
    for law in LAWS:
        for speed in SPEEDS:
            case = Case.model_validate(set_fields(base) | {"friction": law, "speed": speed * pi / 30.0})
            balanced = onset_by_balance(case)
            simulated = [onset_by_simulation(case.model_copy(update={"seed": seed}), balanced) for seed in SEEDS]
            rows.append({"friction": law, "speed_rpm": speed, "balance_N": round(balanced, 2)})
            rows[-1] |= {f"seed_{seed}_N": round(load, 2) for seed, load in zip(SEEDS, simulated, strict=True)}
            rows[-1]["simulated_over_balance"] = round(float(np.mean(simulated)) / balanced, 3)
            print(rows[-1], flush=True)
    return rows


def curve(base: Case, law: str, speed: float, onset: float) -> tuple[np.ndarray, list[float]]:
    """Compute the slip by the balance over the load (N), dense around the ``onset`` (N); speed: rpm."""
    case = Case.model_validate(set_fields(base) | {"friction": law, "speed": speed * pi / 30.0})
    loads_N = np.concatenate([np.geomspace(1.0, 300.0, 40), onset * np.array([0.98, 0.995, 1.005, 1.02])])
    loads_N.sort()
    return loads_N, [balance(case.model_copy(update={"load": float(load)})) for load in loads_N]


def chart(folder: str, base: Case) -> pd.DataFrame:
    """Return a row per law, speed and load: mean and range over seeds, standard deviation in time, balance."""
    table = open_results(folder).table()
    grouped = table.groupby(["friction", "speed", "load"], sort=False)
    summary = pd.DataFrame(grouped["cage.slip.mean"].agg(slip="mean", least="min", most="max"))
    summary["std_in_time"] = grouped["cage.slip.std"].max()
    summary["balance"] = [
        balance(Case.model_validate(set_fields(base) | {"friction": law, "speed": speed, "load": load}))
        for law, speed, load in summary.index
    ]
    summary = summary.reset_index()
    summary["speed"] = (summary["speed"] * 30.0 / pi).round()
    return summary.rename(columns={"speed": "speed_rpm", "load": "load_N"}).round(5)


def set_fields(case: Case) -> dict[str, Any]:
    """Return the fields set in a case."""
    return case.model_dump(exclude_unset=True)


def draw(summary: pd.DataFrame, onset_rows: pd.DataFrame, target: Path) -> None:
    """Draw slip as simulated (marks, bars over the seeds) and by the balance (lines)."""
    base = load_study(STUDY).cases()[0]
    with plt.rc_context(RC):  # type: ignore[arg-type]
        figure, panels = plt.subplots(1, len(LAWS), figsize=(6.9, 3.2), sharey=True, layout="constrained")
        for axes, law in zip(panels, LAWS, strict=True):
            for number, onset in enumerate(onset_rows[onset_rows["friction"] == law].to_dict("records")):
                speed, colour, marker = onset["speed_rpm"], COLOURS[number], MARKERS[number]
                points = summary[(summary["friction"] == law) & (summary["speed_rpm"] == speed)]
                spread = 100.0 * np.abs(points[["least", "most"]].to_numpy().T - points["slip"].to_numpy())
                looks: dict[str, Any] = {"color": colour, "ms": 4.5, "capsize": 2, "label": f"{speed} rpm"}
                axes.errorbar(points["load_N"], 100.0 * points["slip"], spread, fmt=marker, **looks)
                loads_N, slips = curve(base, law, speed, onset["balance_N"])
                axes.plot(loads_N, 100.0 * np.array(slips), color=colour, lw=1.0)
            axes.set(xlabel="Load (N)", xscale="log", yscale="log", ylim=(0.1, 110.0), xlim=(0.9, 360.0))
            axes.set_title(f"friction {law}", loc="left")
            set_log_ticks(axes.xaxis, 0.9, 360.0)
            set_log_ticks(axes.yaxis, 0.1, 110.0)
        panels[0].set_ylabel("Cage slip (%)")
        handles = [*panels[0].get_legend_handles_labels()[0], Line2D([], [], color="0.3", lw=1.0)]
        names = [*panels[0].get_legend_handles_labels()[1], "balance of friction and drag"]
        figure.legend(
            handles, names, loc="outside upper left", ncols=len(names), handlelength=1.5, columnspacing=1.2
        )
        figure.savefig(target)


def draw_tables(table: Path, target: Path) -> None:
    """Draw the committed tables: ``table`` and that of the onsets beside it."""
    draw(pd.read_csv(table), pd.read_csv(table.with_name("slip_onset.csv")), target)


def main() -> None:
    """Compare the results of the study with the balance; determine the onsets; write tables and figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results")
    parser.add_argument("--csv", default="docs/data/slip.csv")
    parser.add_argument("--onsets", default="docs/data/slip_onset.csv")
    parser.add_argument("--png", type=Path, default="docs/figures/slip.png")
    options = parser.parse_args()
    base = load_study(STUDY).cases()[0]
    onset_rows = pd.DataFrame(onsets(base))
    summary = chart(options.results, base)
    summary.to_csv(options.csv, index=False, lineterminator="\n")
    draw(summary, onset_rows, options.png)
    onset_rows.to_csv(options.onsets, index=False, lineterminator="\n")


if __name__ == "__main__":
    main()
