"""Tables of campaigns and studies: random scenes, accuracy, oil films, slip."""

import numpy as np
import pandas as pd

from bearingsim.diagnosis.thresholds import TABLE_FILE, decibels
from docs.scripts.markdown import table
from docs.scripts.measurements import digits, percent, read

KINDS_OF_FEATURES = {"amplitude": "velocity@", "RMS": "velocity.rms", "largest force": "outer_force.max"}
"""Beginning of the names of the features of each kind."""


def random_scenes() -> str:
    """Return the outcomes of random scenes by seed."""
    rows = []
    for seed, group in read("random_scenes").groupby("seed"):
        converged, refused = (group[group.outcome == outcome] for outcome in ("converged", "refused"))
        methods = [int((converged.method == m).sum()) for m in ("verlet", "rodas", "backward-euler")]
        chaotic = [int(converged.chaotic.sum()), int(refused.only_chaotic.sum())]
        others = len(group) - len(converged) - len(refused)
        counts = [
            f"{len(converged)} ({', '.join(map(str, methods))})",
            chaotic[0],
            len(refused),
            chaotic[1],
            others,
        ]
        rows.append([f"{seed}", f"{len(group)}", *map(str, counts)])
    head = ("seed", "scenes", "converged (Verlet, Rodas, backward Euler)", "converged and chaotic", "rejected")
    return table((*head, "rejected only as chaotic and too short", "third outcome"), rows)


def promise() -> str:
    """Return how many random scenes are within a requested accuracy, by kind of feature."""
    rows = []
    promises = read("promise")
    for within in sorted(promises.within.unique(), reverse=True):
        group = promises[promises.within == within]
        scenes = group.drop_duplicates("number")
        cheaper = f"{(scenes.taken != 'reference').sum()} of {len(scenes)}"
        kept = (group.off <= within + 2.0 * group.both).to_numpy()
        is_long = (group.model + group.step + group.scatter <= within).to_numpy()
        kinds = [group.feature.str.startswith(start).to_numpy() for start in KINDS_OF_FEATURES.values()]
        counts = [f"{kept[kind].sum()}" for kind in kinds]
        longer = ", ".join(f"{(~is_long[kind]).sum()}" for kind in kinds)
        rows.append([f"{100 * within:g} %", cheaper, *counts, longer])
    head = ("accuracy", "cheaper model chosen", *(f"{kind} within it" for kind in KINDS_OF_FEATURES))
    return table((*head, "longer record requested for amplitude, RMS, force"), rows)


def friction() -> str:
    """Return how many scenes with friction are within 2 %, their cost and the chosen models."""
    kinds = {"light": ("15 to 300 N", "line, rms, force"), "loaded": ("500 to 5000 N", "line, force")}
    scenes = read("friction")
    rows = []
    for kind, (load, features) in kinds.items():
        group = scenes[scenes.kind == kind]
        within = [count_within(group, features.split(", "), prefix) for prefix in ("", "none_")]
        models = group.taken.replace("reference", "reference without friction").value_counts()
        chosen = ", ".join(f"{model} {count}" for model, count in models.items())
        ratio = f"{group.cpu_s.sum() / group.always_s.sum():.2f}"
        rows.append(
            [
                load,
                features.replace("line", "amplitude").replace("rms", "RMS"),
                *(f"{count} of {len(group)}" for count in within),
                ratio,
                chosen,
            ]
        )
    head = ("load", "features", "within 2 %", "the same, `friction: none`", "CPU time relative to `planar`")
    return table((*head, "chosen model"), rows)


def count_within(group: pd.DataFrame, features: list[str], prefix: str) -> int:
    """Count the scenes in which all errors are at most 2 % plus two combined standard errors (``scatter``)."""
    errors = [group[f"{prefix}{name}_off"] - group[f"{prefix}{name}_scatter"] for name in features]
    return int((pd.concat(errors, axis=1) <= 0.02).all(axis=1).sum())


def paper_literal() -> str:
    """Return lines, RMS and forces of the paper's printed coefficients, at 150 and 300 N."""
    runs = read("paper_literal")
    rows = []
    for m3, method, setting in runs[runs.load_N == 300][["m3", "method", "setting"]].to_numpy():
        of_loads = runs[(runs.m3 == m3) & (runs.setting == setting) & (runs.method == method)]
        lines = zip(of_loads.bpfo_um_s, of_loads.bpfo_standard_error, strict=True)
        levels = zip(of_loads.rms_um_s, of_loads.rms_standard_error, strict=True)
        rows.append(
            [
                f"m3 = {m3:g}, {of_loads.duration_s.iloc[0]:g} s",
                f"`{method}` {setting.replace('us', 'µs')}",
                ", ".join(f"{value:.5g} ({percent(round(error, 5))} %)" for value, error in lines),
                ", ".join(f"{value:.4g} ({percent(error)} %)" for value, error in levels),
                ", ".join(f"{force:.4g}".replace("e+0", "e") for force in of_loads.largest_force_N),
            ]
        )
    errors = "(standard error)"
    headers = ("", "method, setting", f"BPFO amplitude, µm/s {errors}", f"RMS, µm/s {errors}", "largest force, N")
    return table(headers, rows)


def left_out() -> str:
    """Return the effect of a free cage, with dry friction and with oil."""
    rows = []
    changes_of = read("left_out")
    for free in changes_of.free.unique():
        group = changes_of[changes_of.free == free]
        slips = f"{percent(group.slip.min())} to {percent(group.slip.max())} %"
        changes = [group[feature].abs() for feature in ("line", "rms", "force")]
        rows.append([free, slips, *(f"{percent(c.median())} %, {percent(c.max())} %" for c in changes)])
    return table(("free cage with", "slip", "amplitude: median, largest", "RMS", "largest force"), rows)


def film() -> str:
    """Return the ratio of the closed form of the film's damping to solutions."""
    rows = read("film_damping")
    z = rows.z
    ranges = {
        "low frequency, all": z > 0,
        "z < 0.8: squeeze film": z <= 0.8,
        "0.8 < z < 1.8: transition": (z > 0.8) & (z <= 1.8),
        "z > 1.8: entrainment": z > 1.8,
    }
    cells = [[name, *ratio_cells(rows.ratio[chosen])] for name, chosen in ranges.items()]
    cells.append(["the smaller of the two limiting formulas instead", *ratio_cells(rows.hard_min_ratio)])
    own = rows[rows.c_own_solved > 0]
    ratios = own.c_own_closed / own.c_own_solved
    share = f"{np.mean(np.abs(np.log(ratios)) < np.log(3)):.0%} within a factor 3".replace("%", " %")
    cells.append([f"natural frequency, where the solution has damping ({len(own)})", share, quantiles(ratios)])
    central, least = rows.h_solved_um / rows.h_moes_um, rows.least_solved_um / rows.least_moes_um
    cells.append(["central film thickness, solution over Moes' formula", "", quantiles(central)])
    cells.append(["minimum film thickness, solution over Moes' formula", "", quantiles(least)])
    return table(("", "within a factor 1.25", "5, 50 and 95 % quantiles"), cells)


def ratio_cells(ratios: pd.Series) -> tuple[str, str]:
    """Return how many ratios are within a factor 1.25 of one, and their quantiles."""
    return f"{(np.abs(np.log(ratios)) < np.log(1.25)).sum()} of {len(ratios)}", quantiles(ratios)


def quantiles(values: pd.Series) -> str:
    """Return the 5, 50 and 95 % quantiles."""
    return ", ".join(f"{value:.3g}" for value in np.percentile(values, (5, 50, 95)))


def slip_onset() -> str:
    """Return the loads at which gross slip begins, simulated and by the balance of forces."""
    onset = read("slip_onset")
    rows = []
    for friction, group in onset.groupby("friction", sort=False):
        simulated = group[["seed_1_N", "seed_2_N", "seed_3_N"]].mean(axis=1)
        excess = [f"{100.0 * (ratio - 1.0):+.1f} %" for ratio in group.simulated_over_balance]
        cells = (f"{digits(load)} ({e})" for load, e in zip(simulated, excess, strict=True))
        rows.append([f"`{friction}`, simulated, N (relative to the balance)", *cells])
        rows.append(["balance, N", *(f"{load:.4g}" for load in group.balance_N)])
    speeds = onset.speed_rpm.unique()
    return table(("", *(f"{speed} rpm" for speed in speeds)), rows)


def double_impulse() -> str:
    """Return the spacing of entry and strike over wide defects."""
    rows = []
    for (bearing, width, depth), group in read("double_impulse").groupby(["bearing", "width_mm", "depth_um"]):
        columns = [
            ", ".join(f"{rpm}" for rpm in group.rpm),
            ", ".join(digits(value) for value in group.spacing_ms) + " ms",
            ", ".join(f"{value:.2f}" for value in group.ratio),
            ", ".join(f"{value:.2f}" for value in group.spacing_ms * group.rpm / 1000),
            ", ".join(f"{value:.2f}" for value in group.before_end_over_geometry),
        ]
        rows.append([f"{str(bearing).upper()}, {width} mm", f"{depth} µm", *columns])
    head = ("", "depth", "rpm", "entry to strike", "of the crossing", "times speed (ms x 1000 rpm)")
    return table((*head, "before the end / sqrt(2 R_eff d)"), rows)


def diagnosis() -> str:
    """Return found, named and wrong results of simulated signals, in percent, by level."""
    rows = []
    for _, row in read("diagnosis").iterrows():

        def share(name: str, of: str = "signals", row: pd.Series = row) -> str:
            return f"{100.0 * row[name] / row[of]:.3g}" if row[of] else ""

        healthy = row.level_db == "healthy"
        rows.append(
            [
                "healthy" if healthy else f"{row.level_db} dB",
                share("over_threshold")
                + f" ({row.with_clearance} of {row.over_threshold} with clearance)" * healthy,
                "" if healthy else share("right"),
                share("wrong"),
                share("rhythm"),
                share("by_kurtogram"),
                share("wrong_speed_named", "wrong_speeds"),
                share("other_bearing_named", "other_bearings"),
                "" if healthy else f"{100.0 * row.line_error_95:.2f}",
            ]
        )
    head = (
        "level",
        "over the threshold",
        "race named correctly",
        "race named wrongly",
        "other rhythm",
        "over the threshold, kurtogram band",
    )
    return table((*head, "race named, speed wrong by 7 %", "race named, wrong bearing", "line, 95 % within"), rows)


def diagnosis_thresholds() -> str:
    """Return the thresholds of the diagnosis in dB, by revolutions and tolerance."""
    thresholds = pd.read_csv(TABLE_FILE).pivot(index="turns", columns="tolerance", values="score")
    rows = [[f"{turns}", *(f"{decibels(score):.1f}" for score in row)] for turns, row in thresholds.iterrows()]
    return table(("revolutions", *(f"{100.0 * float(str(tolerance)):g} %" for tolerance in thresholds)), rows)
