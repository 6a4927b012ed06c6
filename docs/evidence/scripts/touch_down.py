"""What a contact that closes within a step does to the order of a method, and what stopping on it gains.

    python docs/evidence/scripts/touch_down.py [--part order|gain] [--csv FILE] [--figure FILE]

1. Order. A roller of the NF308's mass, pushed by 2 N, meets a contact k delta^m at 10 mm/s; k of steel at
   m = 10/9, at other m as stiff at 1 um. It flies, touches down at 64 places in a step, and is looked at while it
   is pressed: the root mean square of the error of its place and speed at 13 steps; the order is fitted. Between
   events it is pressed all the while. Fixed steps of every method; "located": a step ends on the touch-down.
2. Gain. `rollers` of the NF308 at 1800 rpm and 150 N over a 0.8 mm slot, 10 ms: relative L2 error of the ring's
   velocity every 5 us against CPU time. Known ahead: nothing; when a contact passes a cusp, as the package has it;
   and when a contact opens or closes. Reference: DOP853 with all known at its tightest; Dormand-Prince's tightest
   says how far both can be believed.
"""

import argparse
import csv
import sys
import time
from collections.abc import Iterator
from math import inf
from typing import Any

import numpy as np
from touch_down_models import (
    FIXED,
    KNOWN,
    LOCATED,
    MASS,
    NAMES,
    OMEGA,
    PUSH,
    SPEED,
    STEEL,
    Contact,
    LocatedContact,
    go,
    start,
)

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.methods.dop853 import Dop853
from bearingsim.core.models.rollers import Rollers

# 1. Order

FLIGHT, PRESSED, PHASES = 10e-6, 10e-6, 64  # s, s: from the start to the touch-down, and on
COUNTS = [round(10 * 2 ** (k / 2)) for k in range(13)]  # of steps in FLIGHT + PRESSED


def stiffness(m: float) -> float:
    """k (N/m^m) of a contact as stiff at 1 um as steel's."""
    return STEEL * (1e-6) ** (10 / 9 - m)


def after(name: str, model: Any, t: float, steps: int, q: float, v: float) -> tuple[float, float]:
    """Place (m) and speed (m/s) at ``t`` (s), in even steps; one ends on a touch-down that the model knows."""
    y, h, out = lay.make_buffer(1, MASS), t / steps, np.empty((1, 2))
    y[lay.RADIAL], y[lay.RADIAL_V] = q, v
    kind: Any = NAMES[name]
    method = kind(h) if name in FIXED else kind(h, 1e30, 1e30, 1e30, h)
    start(method, model, 0.0, y)
    y[lay.H_NEXT] = h
    (LOCATED[name] if name in FIXED and isinstance(model, LocatedContact) else go)(method, model, 0, y, steps, out)
    return float(y[lay.RADIAL]), float(y[lay.RADIAL_V])


def exactly(model: Any, t: float, q: float, v: float) -> tuple[float, float]:
    """The same, the touch-down located, to rounding."""
    y, out = lay.make_buffer(1, MASS), np.empty((1, 2))
    y[lay.RADIAL], y[lay.RADIAL_V] = q, v
    method = Dop853(t, 1e-14, 1e-20, 1e-16, t / 100)
    start(method, model, 0.0, y)
    go(method, model, 0, y, 1, out)
    assert y[lay.FAILED] == 0.0
    return float(y[lay.RADIAL]), float(y[lay.RADIAL_V])


def starts(scene: str, h: float) -> list[tuple[float, float]]:
    """Places (m) and speeds (m/s) to start from: in flight, 64 within a step of ``h`` (s); or pressed."""
    if scene == "between":
        return [(-2e-8 - 2e-8 * n / PHASES, -SPEED) for n in range(PHASES)]
    times = FLIGHT + h * (np.arange(PHASES) + 0.5) / PHASES
    return [(SPEED * t - 0.5 * PUSH / MASS * t * t, -SPEED + PUSH / MASS * t) for t in times]


def orders() -> Iterator[dict[str, Any]]:
    """Errors at every number of steps: of each method, exponent and scene."""
    for m in (1.0, 10.0 / 9.0, 1.5):
        known = LocatedContact(PUSH, stiffness(m), m)
        for scene in ("touch-down", "located", "between"):
            span = PRESSED if scene == "between" else FLIGHT + PRESSED
            model = known if scene == "located" else Contact(*known)
            for steps in COUNTS if scene != "between" else [count // 2 for count in COUNTS]:
                begun = starts(scene, span / steps)
                exact = [exactly(known, span, q, v) for q, v in begun]
                for name in NAMES:
                    found = [after(name, model, span, steps, q, v) for q, v in begun]
                    apart = (np.array(found) - exact) / [SPEED / OMEGA, SPEED]
                    error = float(np.sqrt(np.mean(apart**2)))
                    labels = {"part": "order", "scene": scene, "m": round(m, 4), "method": name, "known": ""}
                    yield labels | {"setting": span / steps, "error": error, "cpu_s": "", "evaluations": ""}


def fitted_order(rows: list[dict[str, Any]]) -> float:
    """Slope of log error over log step, where it is above rounding."""
    used = [(row["setting"], row["error"]) for row in rows if 3e-13 < row["error"] < 1e-2]
    steps, errors = np.log(np.array(used).reshape(-1, 2)).T
    return float(np.polyfit(steps, errors, 1)[0]) if len(used) > 2 else float("nan")


# 2. Gain

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
SCENE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "rollers", "defect": SLOT}
PER_STEP = {"verlet": 1, "rk4": 4, "nystrom": 4}  # evaluations
DURATION, EVERY = 10e-3, 5e-6  # s


def ring_velocity(name: str, known: str, setting: float, case: Case) -> tuple[np.ndarray, float, float]:
    """The ring's velocity (n, 2) every 5 us; CPU seconds, the best of three; evaluations of the model."""
    model = KNOWN[known](*assemble.model(case))
    kind: Any = NAMES[name]
    stride = max(1, round(EVERY / setting)) if name in FIXED else 1
    method = kind(EVERY / stride) if name in FIXED else kind(EVERY, setting, 1e-5 * setting, 1e-2 * setting, 2e-5)
    drive = LOCATED[name] if known == "contacts" and name in FIXED else go
    best, evaluations, out = inf, 0.0, np.empty((round(DURATION / EVERY), 2))
    rest, _ = assemble.start(case, Rollers(*model))
    for _ in range(3):
        y = rest.copy()
        start(method, model, 0.0, y)
        drive(method, model, 0, y, stride, out[:1].copy())  # compiled
        y = rest.copy()
        start(method, model, 0.0, y)
        y[lay.STEPS_TAKEN], y[lay.EVALUATIONS] = 0.0, 0.0
        began = time.thread_time()
        drive(method, model, 0, y, stride, out)
        best = min(best, time.thread_time() - began)
        evaluations = (
            (y[lay.STEPS_TAKEN] or stride * len(out)) * PER_STEP[name] if name in FIXED else y[lay.EVALUATIONS]
        )
        if y[lay.FAILED]:
            out[:] = np.nan
    return out, best, evaluations


def gains(scenes: dict[str, dict]) -> Iterator[dict[str, Any]]:
    """Error against CPU time on the bearing, of each method with and without location."""
    for scene, given in scenes.items():
        case = Case.model_validate(SCENE | given)
        exact, _, _ = ring_velocity("dop853", "contacts", 1e-11, case)
        for name in NAMES:
            settings = [2e-6 / 2**k for k in range(7)] if name in FIXED else [10.0**-k for k in range(3, 11)]
            for known in [*KNOWN][name in FIXED :]:
                for setting in settings:
                    found, cpu, evaluations = ring_velocity(name, known, setting, case)
                    error = float(np.linalg.norm(found - exact) / np.linalg.norm(exact))
                    labels = {"part": "gain", "scene": scene, "m": round(10 / 9, 4), "method": name}
                    yield labels | {
                        "known": known,
                        "setting": setting,
                        "error": error,
                        "cpu_s": round(cpu, 6),
                        "evaluations": round(evaluations),
                    }


SCENES: dict[str, dict] = {
    f"chi = {chi} s/m": {"contact": {"damping": {"chi": f"{chi} s/m"}}} for chi in (50, 200)
}
"""With a tenth of this damping the rollers outside the load zone chatter, and nothing converges."""


# Charts


def draw(rows: list[dict[str, Any]], path: str) -> None:
    """Order at a touch-down, and error against CPU time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 1 + len(SCENES), figsize=(5.0 * (1 + len(SCENES)), 4.6))
    colours = dict(zip(NAMES, plt.rcParams["axes.prop_cycle"].by_key()["color"], strict=False))
    for name, c in colours.items():
        for scene, style in (("touch-down", "-"), ("located", "--"), ("between", ":")):
            some = [r for r in rows if (r["scene"], r["method"], f"{r['m']:.3f}") == (scene, name, "1.111")]
            steps, errors = [1e6 * r["setting"] for r in some], [r["error"] for r in some]
            axes[0].loglog(steps, errors, style, c=c, label=name if scene == "touch-down" else None)
        for axis, scene in zip(axes[1:], SCENES, strict=True):
            for known, style in (("nothing", ":^"), ("cusps", "-o"), ("contacts", "--s")):
                some = [r for r in rows if (r["scene"], r["method"], r["known"]) == (scene, name, known)]
                axis.loglog([r["cpu_s"] for r in some], [r["error"] for r in some], style, ms=3, c=c)
    axes[0].set(xlabel="step (us)", ylabel="error of place and speed")
    axes[0].set_title("one contact, m = 10/9\n- unforeseen, -- located, .. pressed all the while", fontsize=9)
    axes[0].legend()
    for axis, scene in zip(axes[1:], SCENES, strict=True):
        axis.set(xlabel="CPU time for 10 ms (s)", ylabel="error of the ring's velocity", ylim=(1e-9, 3.0))
        axis.set_title(f"rollers, {scene}; known ahead:\n.. nothing, - cusps, -- cusps and contacts", fontsize=9)
    for axis in axes:
        axis.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def save(rows: list[dict[str, Any]], path: str) -> None:
    """Write the table."""
    with open(path, "w", newline="") as target:
        table = csv.DictWriter(target, [*rows[0]], lineterminator="\n")
        table.writeheader()
        for row in rows:
            table.writerow({name: f"{x:.4g}" if isinstance(x, float) else x for name, x in row.items()})


def main() -> None:
    """Print the orders; write the table and the figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--csv")
    parser.add_argument("--figure")
    parser.add_argument("--part", choices=("order", "gain"))
    options = parser.parse_args()
    rows = [*orders()] if options.part != "gain" else []
    for key in dict.fromkeys((row["m"], row["scene"], row["method"]) for row in rows):
        some = [row for row in rows if (row["m"], row["scene"], row["method"]) == key]
        errors = " ".join(f"{row['error']:.1e}" for row in some[::3])
        print("m = {}, {}, {}:".format(*key), f"order {fitted_order(some):.2f};", errors, file=sys.stderr)
    if options.part != "order":
        for row in gains(SCENES):
            rows.append(row)
            print(row, file=sys.stderr, flush=True)
    if options.csv:
        save(rows, options.csv)
    if options.figure:
        draw(rows, options.figure)


if __name__ == "__main__":
    main()
