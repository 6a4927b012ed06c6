"""Tables of pages, written from the measurements in ``docs/data``.

A page has a block ``<!-- table: NAME -->`` ... ``<!-- end of table -->``; `make docs-reference` writes the table
of that name between the two lines.
"""

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from docs.scripts.markdown import table
from docs.scripts.navigation import DOCS

BLOCK = re.compile(r"(<!-- table: ([\w ]+) -->\n)(?:(?!<!-- end of table).*\n)*(<!-- end of table -->)")
MODELS = {
    "impulse": (
        "outer ring, as an oscillator under impulses, in closed form",
        "no contact forces, no varying compliance, no clearance",
        "only lines and sidebands of a defect are needed",
    ),
    "static": (
        "nothing: equilibrium at each cage angle",
        "no inertia, no damping",
        "low speed; load sharing, varying compliance",
    ),
    "ring": (
        "outer ring, x and y",
        "rollers without mass follow the races",
        "lines of narrow or shallow defects",
    ),
    "rollers": (
        "+ each roller, radially",
        "rollers roll, the cage turns at its kinematic speed",
        "impacts: forces, RMS, acceleration; a flexible ring",
    ),
    "planar": (
        "+ angle and spin of each roller, cage, rotation and centres of rings",
        "rollers do not tilt; rings are rigid",
        "slip, drag, cage forces, ramps, gravity, a shaft",
    ),
    "spatial": (
        "+ axis and axial motion of each roller, tilt of rings and cage",
        "rings are rigid",
        "tilt, skew, off-centre defects, misalignment, profiles",
    ),
}
"""What moves in each model, what it assumes, and when it is to be used."""
SCENES = {
    "healthy": "healthy",
    "0.8 mm slot": "0.8 mm slot",
    "0.8 mm slot, inner": "the same on the inner race",
    "0.8 mm slot, roller": "the same on a roller",
    "9 mm bowl": "9 mm bowl",
}
LAWS = {
    "chi": "`hunt-crossley`",
    "kraemer": "`kraemer`",
    "m3 = 0": "`general`, m2 = 1, m3 = 0",
    "m3 = 1": "`general`, m3 = 1",
    "m3 = 2": "`general`, m3 = 2",
    "m3 = 1.5": "`general`, m3 = 1.5",
    "m1 = 1.2": "`constant`, m1 = 1.2",
    "m1 = 1.2, m3 = 1.5": "both",
}
KINDS_OF_FEATURES = {"line": "velocity@", "RMS": "velocity.rms", "largest force": "outer_force.max"}
"""Beginning of the names of the features of each kind."""


def models() -> str:
    """Return the table of the models with their cost."""
    costs, jobs = read("step_cost"), read("job_cost")
    steps = costs[(costs.scene == "0.8 mm slot") & (costs.method != "rk4")].set_index("model").ns_per_step
    seconds = jobs.set_index(["model", "response"]).cpu_s_per_s
    rows = []
    for name, texts in MODELS.items():
        step = f"{steps[name] / 1000:.2g} µs" if name in steps else ""
        times = [f"{seconds[name, r]:.2g} s" if (name, r) in seconds else "" for r in RESPONSES]
        rows.append([f"`{name}`", *texts, step, *times])
    return table(
        ("model", "moves", "assumes", "use for", "a step", *(f"1 s of signal, {r}" for r in RESPONSES)), rows
    )


RESPONSES = ("periodic", "in full")
"""Responses of jobs in job_cost.csv."""


def steps(column: str, unit: str) -> str:
    """Return a column of the costs of a step, by scene over model and method."""
    costs = read("step_cost").fillna("")
    costs = costs[costs.scene.isin(SCENES)]
    costs["variant"] = "`" + costs.model + "` " + costs.method
    wide = costs.pivot(index="scene", columns="variant", values=column)[costs.variant.unique()]
    rows = ([title, *map(digits, wide.loc[scene].to_numpy())] for scene, title in SCENES.items())
    return table((unit, *(name.replace("` ", "`, ").removesuffix(", ") for name in wide.columns)), rows)


def laws() -> str:
    """Return the costs of a Verlet step by contact law."""
    costs = read("step_cost")
    costs = costs[costs.scene.str.startswith("law ")].pivot(index="scene", columns="model", values="ns_per_step")
    rows = (
        [title, *(digits(costs[m][f"law {law}"]) for m in ("rollers", "planar"))] for law, title in LAWS.items()
    )
    return table(("ns per step", "`rollers`", "`planar`"), rows)


def lanes() -> str:
    """Return the costs of a Verlet step by number of rollers."""
    costs = read("step_cost")
    costs = costs[costs.scene == "lanes"]
    head = ("`rollers`, Verlet", *(f"{count} rollers" for count in costs.rollers))
    return table(head, [("ns per step", *map(digits, costs.ns_per_step))])


def arrow() -> str:
    """Return the costs of a factorisation and solution of an implicit step."""
    costs = read("arrow")
    costs["total"] = costs.factor_us + costs.solve_us
    rows = []
    for (own, border), group in costs.groupby(["own", "border"]):
        at = group.set_index("rollers")
        rows.append([f"{own} + {border}", digits(at.total[13]), digits(at.total[104]), digits(at.dense_us[104])])
    return table(
        ("coordinates of a roller + border", "13 rollers", "104 rollers", "the same, dense (NumPy)"), rows
    )


def derivatives() -> str:
    """Return CPU times of implicit runs with differences over those with exact derivatives."""
    ratios = read("derivatives").groupby(["cage", "method"]).ratio.median()
    methods = ("rodas", "backward-euler")
    rows = ([cage, *(f"{ratios[cage, method]:.2f}" for method in methods)] for cage in ("kinematic", "free"))
    return table(("cage", *(f"`{method}`" for method in methods)), rows)


def start_up() -> str:
    """Return the CPU times of commands that compute nothing."""
    rows = ((f"`{row.command}`", f"{row.cpu_s:.2f}") for row in read("start_up").itertuples())
    return table(("command", "CPU time, s"), rows)


def step_fractions() -> str:
    """Return the errors of steps, as fractions of the stability limit, in ordinary scenes."""
    errors = read("step_fraction")
    errors = errors[~errors.scene.str.contains("6000 rpm|chi 5 s/m")]
    features = ("velocity@BPFO", "velocity.rms", "outer_force.max")
    rows = []
    for (method, fraction), group in errors.groupby(["method", "fraction"], sort=False):
        completed = group[group.stopped.isna()]
        pairs = [f"{percent(completed[f].median())}, {percent(completed[f].max())}" for f in features]
        texts = pairs if len(completed) else [""] * len(features)
        rows.append([f"`{method}`", f"{fraction}", *texts, f"{len(group) - len(completed)} of {len(group)}"])
    return table(("method", "step / limit", "line, %", "RMS, %", "largest force, %", "stopped"), rows)


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
    head = ("seed", "scenes", "converged (Verlet, Rodas, backward Euler)", "of them chaotic", "rejected")
    return table((*head, "of them only as chaotic and too short", "third outcome"), rows)


def promise() -> str:
    """Return how many random scenes are within a requested accuracy."""
    rows = []
    promises = read("promise")
    for within in sorted(promises.within.unique(), reverse=True):
        group = promises[promises.within == within]
        scenes = group.drop_duplicates("number")
        below = f"{(scenes.taken != 'reference').sum()} of {len(scenes)}"
        kept = (group.off <= within + 2.0 * group.both).to_numpy()
        is_long = (group.model + group.step + group.scatter <= within).to_numpy()
        kinds = [group.feature.str.startswith(start).to_numpy() for start in KINDS_OF_FEATURES.values()]
        counts = [f"{kept[kind].sum()}" for kind in kinds]
        longer = ", ".join(f"{(~is_long[kind]).sum()}" for kind in kinds)
        rows.append([f"{100 * within:g} %", below, *counts, longer])
    head = ("accuracy", "below the reference", *(f"{kind} within it" for kind in KINDS_OF_FEATURES))
    return table((*head, "longer record requested"), rows)


def left_out() -> str:
    """Return the effect of a free cage, with dry friction and with oil."""
    rows = []
    changes_of = read("left_out")
    for free in changes_of.free.unique():
        group = changes_of[changes_of.free == free]
        slips = f"{percent(group.slip.min())} to {percent(group.slip.max())} %"
        changes = [group[feature].abs() for feature in ("line", "rms", "force")]
        rows.append([free, slips, *(f"{percent(c.median())} %, {percent(c.max())} %" for c in changes)])
    return table(("free cage with", "slip", "line: median, largest", "RMS", "largest force"), rows)


def film() -> str:
    """Return the ratio of the closed form of the film's damping to solutions."""
    rows = read("film_damping")
    z = rows.z
    ranges = {
        "slow oscillations, all": z > 0,
        "z < 0.8: squeezed": z <= 0.8,
        "0.8 < z < 1.8: between": (z > 0.8) & (z <= 1.8),
        "z > 1.8: carried": z > 1.8,
    }
    cells = [[name, *ratio_cells(rows.ratio[chosen])] for name, chosen in ranges.items()]
    cells.append(["the smaller of the two terms instead", *ratio_cells(rows.hard_min_ratio)])
    own = rows[rows.c_own_solved > 0]
    ratios = own.c_own_closed / own.c_own_solved
    share = f"{np.mean(np.abs(np.log(ratios)) < np.log(3)):.0%} within a factor 3".replace("%", " %")
    cells.append([f"own frequency, where the solution damps ({len(own)})", share, quantiles(ratios)])
    central, least = rows.h_solved_um / rows.h_moes_um, rows.least_solved_um / rows.least_moes_um
    cells.append(["Moes' film: solution over formula, central", "", quantiles(central)])
    cells.append(["the same, least", "", quantiles(least)])
    return table(("", "within a factor 1.25", "5 %, 50 %, 95 %"), cells)


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
        rows.append([f"`{friction}`, simulated, N", *map(digits, simulated)])
        excess = group.simulated_over_balance - 1.0
        rows.append(["balance, N", *(f"{b:.4g} ({e:+.0%})" for b, e in zip(group.balance_N, excess, strict=True))])
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


def read(name: str) -> pd.DataFrame:
    """Read a table of measurements."""
    return pd.read_csv(DOCS / "data" / f"{name}.csv")


def digits(value: float) -> str:
    """Return a number with three digits; whole numbers in full."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def percent(share: float) -> str:
    """Return a share in per cent with two digits; whole numbers in full."""
    return f"{100 * share:.0f}" if share >= 1 else f"{100 * share:.2g}"


TABLES: dict[str, Callable[[], str]] = {
    "models": models,
    "step cost": lambda: steps("ns_per_step", "ns per step"),
    "run cost": lambda: steps("cpu_s_per_simulated_s", "CPU s per second"),
    "law cost": laws,
    "lane cost": lanes,
    "arrow": arrow,
    "derivatives": derivatives,
    "start up": start_up,
    "step fractions": step_fractions,
    "random scenes": random_scenes,
    "promise": promise,
    "left out": left_out,
    "film": film,
    "slip onset": slip_onset,
    "double impulse": double_impulse,
}
"""Function that writes each table, by the name in its block."""


def pages() -> Iterator[Path]:
    """Yield the pages that have blocks."""
    yield from (page for page in sorted(DOCS.rglob("*.md")) if BLOCK.search(page.read_text(encoding="utf-8")))


def current(page: Path) -> str:
    """Return the text of a page with its tables written anew."""
    text = page.read_text(encoding="utf-8")
    return BLOCK.sub(lambda block: f"{block[1]}{TABLES[block[2]]()}\n{block[3]}", text)
