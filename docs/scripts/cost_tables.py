"""Tables of CPU times and of steps."""

from docs.scripts.markdown import table
from docs.scripts.measurements import digits, percent, read

MODELS = {
    "impulse": (
        "outer ring in x and y, an oscillator under impulses (closed form)",
        "no contact forces, no varying compliance, no clearance",
        "spectral lines and sidebands of a defect",
    ),
    "static": (
        "none: equilibrium at each cage angle",
        "no inertia, no damping",
        "low speed; load distribution, varying compliance",
    ),
    "ring": (
        "outer ring in x and y",
        "massless rollers follow the races",
        "amplitudes of narrow or shallow defects",
    ),
    "rollers": (
        "+ radial motion of each roller",
        "pure rolling, the cage rotates at its kinematic speed",
        "impacts: forces, RMS, acceleration; a flexible ring",
    ),
    "planar": (
        "+ orbital angle and spin of each roller, cage, rotation and centres of rings",
        "rollers do not tilt; rings are rigid",
        "slip, drag, cage forces, speed ramps, gravity, a shaft",
    ),
    "spatial": (
        "+ tilt, skew and axial motion of each roller, tilt of rings and cage",
        "rings are rigid",
        "tilt, skew, off-centre defects, misalignment, profiles",
    ),
}
"""Degrees of freedom, assumptions and use of each model."""
RESPONSES = ("periodic", "in full")
"""Responses of jobs in job_cost.csv."""
SCENES = {
    "healthy": "healthy",
    "0.8 mm slot": "0.8 mm slot",
    "0.8 mm slot, inner": "the same on the inner race",
    "0.8 mm slot, roller": "the same on a roller",
    "9 mm bowl": "9 mm circular defect",
}
LAWS = {
    "chi": "`hunt-crossley`",
    "kraemer": "`kraemer`",
    "m3 = 0": "`general`, m2 = 1, m3 = 0",
    "m3 = 1": "`general`, m3 = 1",
    "m3 = 2": "`general`, m3 = 2",
    "m3 = 1.5": "`general`, m3 = 1.5",
    "m1 = 1.2": "`constant`, m1 = 1.2",
    "m1 = 1.2, m3 = 1.5": "`constant`, m1 = 1.2, with `general`, m3 = 1.5",
}


def models() -> str:
    """Return the table of the models with their cost."""
    costs, jobs = read("step_cost"), read("job_cost")
    steps = costs[(costs.scene == "0.8 mm slot") & (costs.method != "rk4")].set_index("model").ns_per_step
    seconds = jobs.set_index(["model", "response"]).cpu_s_per_s
    rows = []
    for name, texts in MODELS.items():
        step = f"{steps[name] / 1000:.2g}\N{NO-BREAK SPACE}µs" if name in steps else ""
        times = [f"{seconds[name, r]:.2g}\N{NO-BREAK SPACE}s" if (name, r) in seconds else "" for r in RESPONSES]
        rows.append([f"`{name}`", *texts, step, *times])
    return table(
        (
            "model",
            "degrees of freedom",
            "assumptions",
            "use for",
            "one step",
            *(f"1 s of signal, {response}" for response in RESPONSES),
        ),
        rows,
    )


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
