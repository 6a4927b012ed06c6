"""What a contact that closes within a step does to the order of a method, and what stopping on it gains.

    python benchmarks/touch_down.py [--part order|gain] [--csv FILE] [--figure FILE]

1. Order. A roller of the NF308's mass, pushed by 2 N, meets a contact k delta^m at 10 mm/s; k of steel at m = 10/9,
   at other m as stiff at 1 um. It flies, touches down at 64 places in a step, and is looked at while it is pressed:
   the root mean square of the error of its place and speed at 13 steps; the order is fitted. Between events it is
   pressed all the while. Fixed steps of every method; "located": a step ends on the touch-down.
2. Gain. `rollers` of the NF308 at 1800 rpm and 150 N over a 0.8 mm slot, 10 ms: relative L2 error of the ring's
   velocity every 5 us against CPU time, each method as it is and stopping wherever a contact opens or closes.
   Reference: DOP853 located at its tightest; Dormand-Prince's tightest run says how far both can be believed.
"""

import argparse
import csv
import sys
import time
from collections.abc import Iterator
from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim import build
from bearingsim.config import Case
from bearingsim.core.defects import Pits
from bearingsim.core.events import next_cusp
from bearingsim.core.jit import jit
from bearingsim.core.layout import (
    ACCELERATION,
    COS,
    DELTA_I,
    DELTA_O,
    EVALUATED,
    FAILED,
    H_NEXT,
    LANES,
    NEXT_STOP,
    SIN,
    TAKEN,
    V_I,
    V_O,
    VELOCITY,
    A,
    Q,
    V,
    X,
    Y,
    buffer,
)
from bearingsim.core.methods.adaptive import HOP
from bearingsim.core.methods.dop853 import Dop853
from bearingsim.core.methods.dormand_prince import DormandPrince
from bearingsim.core.methods.interface import prepare, step
from bearingsim.core.methods.nystrom import Nystrom
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.interface import accelerations, freedoms, keep_extremes, width
from bearingsim.core.models.rollers import Rollers
from bearingsim.core.parameters import Bearing, Support
from bearingsim.core.pit_contact import standing

NAMES = {
    "verlet": Verlet,
    "rk4": RungeKutta4,
    "nystrom": Nystrom,
    "dormand-prince": DormandPrince,
    "dop853": Dop853,
}
FIXED, ADAPTIVE = ("verlet", "rk4", "nystrom"), ("dormand-prince", "dop853")
MASS, STEEL, PUSH, SPEED = 0.010654, 1.57e9, 2.0, 10e-3
OMEGA = 1.5e5  # 1/s: about that of the contact in motion; what a place counts beside a speed
CLOSE = 1e-9  # s: from so near a contact comes straight to its touch-down


@jit
def until_zero(x, v, a):
    """The first time (s) ahead at which x + v t + a t^2/2 is zero, and leaves it; inf if never."""
    inside = v * v - 2.0 * a * x
    if inside < 0.0:
        return inf
    root = sqrt(inside)
    least = inf
    for sign in (-1.0, 1.0):
        below = -v + sign * root  # 2 x/(-v +- root): no cancellation, no division by a
        if below != 0.0:
            t = 2.0 * x / below
            least = t if 1e-14 < t < least else least
    return least


@jit
def closing_in(t, wait):
    """Time (s) to stop at on the way to an event predicted ``wait`` (s) ahead of ``t``."""
    return t + (wait if wait < CLOSE else 0.98 * wait)


# 1. One contact


ONE = Bearing(1, 1.0, 3.0, 1.0, 0.0, MASS, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0)


class Contact(NamedTuple):
    """q'' = (-push + k <-q>^m)/mass: a roller over a floor."""

    push: float
    k: float
    m: float
    bearing: Bearing = ONE


class LocatedContact(NamedTuple):
    """The same, its touch-down known."""

    push: float
    k: float
    m: float
    bearing: Bearing = ONE


def _contact(model, t, y):
    y[A] = (-model.push + model.k * max(-y[Q], 0.0) ** model.m) / MASS


for _type in (Contact, LocatedContact):
    width.register(_type)(lambda model: LANES + 8)
    freedoms.register(_type)(lambda model: (1, 0))
    keep_extremes.register(_type)(lambda model, y: None)
    accelerations.register(_type)(_contact)
next_cusp.register(Contact)(lambda model, t, y: inf)
next_cusp.register(LocatedContact)(lambda model, t, y: t + until_zero(y[Q], y[V], y[A]) if y[Q] > 0.0 else inf)


# 2. The bearing


class LocatedRollers(NamedTuple):
    """``Rollers`` whose contacts are known to open and close."""

    bearing: Bearing
    support: Support
    outer: Any
    inner: Any
    pits: Pits


@jit
def plain(model):
    """The model as the package has it."""
    return Rollers(model.bearing, model.support, model.outer, model.inner, model.pits)


width.register(LocatedRollers)(lambda model: width(plain(model)))
freedoms.register(LocatedRollers)(lambda model: freedoms(plain(model)))
keep_extremes.register(LocatedRollers)(lambda model, y: keep_extremes(plain(model), y))
accelerations.register(LocatedRollers)(lambda model, t, y: accelerations(plain(model), t, y))
standing.register(LocatedRollers)(lambda model, d, t, y: standing(plain(model), d, t, y))


@next_cusp.register(LocatedRollers)
def _next_cusp(model, t, y):
    soonest = inf
    for j in range(model.bearing.Z):
        ring = y[ACCELERATION + X] * y[COS + j] + y[ACCELERATION + Y] * y[SIN + j]
        soonest = min(soonest, until_zero(y[DELTA_O + j], y[V_O + j], y[A + j] - ring))
        soonest = min(soonest, until_zero(y[DELTA_I + j], y[V_I + j], -y[A + j]))
    return min(closing_in(t, soonest), next_cusp(plain(model), t, y))


# Steps


def stepper(parameters: Any) -> Any:
    """A fixed-step method that ends its steps on what ``next_cusp`` knows of."""

    @jit
    def located(method, model, t, y):
        end = t + method.h
        while end - t > HOP:
            wait = next_cusp(model, t, y) - t
            if wait <= HOP:
                for k in range(width(model)):
                    y[VELOCITY + k] += 2.0 * HOP * y[ACCELERATION + k]
                    y[k] += 2.0 * HOP * y[VELOCITY + k]
                t += 2.0 * HOP
                accelerations(model, t, y)
            else:
                part = min(end - t, wait)
                step(parameters(part), model, t, y)
                y[TAKEN] += 1.0
                t += part

    @jit
    def go(method, model, first, y, stride, out):
        for n in range(len(out)):
            for k in range(stride):
                located(method, model, (first + n * stride + k) * method.h, y)
            out[n, 0], out[n, 1] = y[VELOCITY + X], y[VELOCITY + Y]

    return go


@jit
def start(method, model, t, y):
    """Ready for the first step."""
    accelerations(model, t, y)
    prepare(method, model, t, y)


@jit
def go(method, model, first, y, stride, out):
    """Steps; the ring's velocity after every ``stride`` of them into out (n, 2)."""
    for n in range(len(out)):
        for k in range(stride):
            step(method, model, (first + n * stride + k) * method.h, y)
        out[n, 0], out[n, 1] = y[VELOCITY + X], y[VELOCITY + Y]


LOCATED = {name: stepper(NAMES[name]) for name in FIXED}


# 1. Order

FLIGHT, PRESSED, PHASES = 10e-6, 10e-6, 64  # s, s: from the start to the touch-down, and on
COUNTS = [round(10 * 2 ** (k / 2)) for k in range(13)]  # of steps in FLIGHT + PRESSED


def stiffness(m: float) -> float:
    """k (N/m^m) of a contact as stiff at 1 um as steel's."""
    return STEEL * (1e-6) ** (10 / 9 - m)


def after(name: str, model: Any, t: float, steps: int, q: float, v: float) -> tuple[float, float]:
    """Place (m) and speed (m/s) at ``t`` (s), in even steps; one ends on the touch-down if the model knows of it."""
    y, h, out = buffer(1, MASS), t / steps, np.empty((1, 2))
    y[Q], y[V] = q, v
    kind: Any = NAMES[name]
    method = kind(h) if name in FIXED else kind(h, 1e30, 1e30, 1e30, h)
    start(method, model, 0.0, y)
    y[H_NEXT] = h
    (LOCATED[name] if name in FIXED and isinstance(model, LocatedContact) else go)(method, model, 0, y, steps, out)
    return float(y[Q]), float(y[V])


def exactly(model: Any, t: float, q: float, v: float) -> tuple[float, float]:
    """The same, the touch-down located, to rounding."""
    y, out = buffer(1, MASS), np.empty((1, 2))
    y[Q], y[V] = q, v
    method = Dop853(t, 1e-14, 1e-20, 1e-16, t / 100)
    start(method, model, 0.0, y)
    go(method, model, 0, y, 1, out)
    assert y[FAILED] == 0.0
    return float(y[Q]), float(y[V])


def starts(scene: str, h: float) -> list[tuple[float, float]]:
    """Places (m) and speeds (m/s) to start from: in flight, at 64 distances within a step of ``h`` (s); or pressed."""
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
                    labels = {"part": "order", "scene": scene, "m": round(m, 4), "method": name, "located": ""}
                    yield labels | {"setting": span / steps, "error": error, "cpu_s": "", "evaluations": ""}


def fitted_order(rows: list[dict[str, Any]]) -> float:
    """Slope of log error over log step, where it is above rounding."""
    used = [(row["setting"], row["error"]) for row in rows if 3e-13 < row["error"] < 1e-2]
    return float(np.polyfit(*np.log(np.array(used)).T, 1)[0]) if len(used) > 2 else float("nan")


# 2. Gain

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
SCENE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "rollers", "defect": SLOT}
DURATION, EVERY = 10e-3, 5e-6  # s


def ring_velocity(name: str, located: bool, setting: float, case: Case) -> tuple[np.ndarray, float, float]:
    """The ring's velocity (n, 2) every 5 us; CPU seconds, the best of three; evaluations of the model."""
    model = build.model(case)
    kind: Any = NAMES[name]
    stride = max(1, round(EVERY / setting)) if name in FIXED else 1
    method = kind(EVERY / stride) if name in FIXED else kind(EVERY, setting, 1e-5 * setting, 1e-2 * setting, 2e-5)
    if located:
        model = LocatedRollers(*model)
    drive = LOCATED[name] if located and name in FIXED else go
    best, evaluations, out = inf, 0.0, np.empty((round(DURATION / EVERY), 2))
    rest, _ = build.start(case, Rollers(*model))
    for _ in range(3):
        y = rest.copy()
        start(method, model, 0.0, y)
        drive(method, model, 0, y, stride, out[:1].copy())  # compiled
        y = rest.copy()
        start(method, model, 0.0, y)
        y[TAKEN], y[EVALUATED], y[NEXT_STOP] = 0.0, 0.0, y[NEXT_STOP]
        began = time.thread_time()
        drive(method, model, 0, y, stride, out)
        best = min(best, time.thread_time() - began)
        evaluations = y[EVALUATED] or stride * len(out)
        if y[FAILED]:
            out[:] = np.nan
    return out, best, evaluations


def gains(scenes: dict[str, dict]) -> Iterator[dict[str, Any]]:
    """Error against CPU time on the bearing, of each method with and without location."""
    for scene, given in scenes.items():
        case = Case.model_validate(SCENE | given)
        exact, _, _ = ring_velocity("dop853", True, 1e-11, case)
        for name in NAMES:
            settings = [2e-6 / 2**k for k in range(7)] if name in FIXED else [10.0**-k for k in range(3, 11)]
            for located in (False, True):
                for setting in settings:
                    found, cpu, evaluations = ring_velocity(name, located, setting, case)
                    error = float(np.linalg.norm(found - exact) / np.linalg.norm(exact))
                    labels = {"part": "gain", "scene": scene, "m": round(10 / 9, 4), "method": name}
                    yield labels | {
                        "located": int(located),
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
    """Order at a touch-down beside error against CPU time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 1 + len(SCENES), figsize=(5.0 * (1 + len(SCENES)), 4.4))
    colours = dict(zip(NAMES, plt.rcParams["axes.prop_cycle"].by_key()["color"], strict=False))
    for name in NAMES:
        for scene, style in (("touch-down", "-"), ("located", "--"), ("between", ":")):
            some = [r for r in rows if (r["scene"], r["method"], r["m"]) == (scene, name, round(10 / 9, 4))]
            label = name if scene == "touch-down" else None
            axes[0].loglog(
                [1e6 * r["setting"] for r in some], [r["error"] for r in some], style, c=colours[name], label=label
            )
        for axis, scene in zip(axes[1:], SCENES, strict=True):
            for located, style in ((0, "-o"), (1, "--s")):
                some = [r for r in rows if (r["scene"], r["method"], r["located"]) == (scene, name, located)]
                axis.loglog([r["cpu_s"] for r in some], [r["error"] for r in some], style, ms=3, c=colours[name])
    axes[0].set(
        xlabel="step (us)",
        ylabel="error of the speed",
        title="one contact, m = 10/9: - not, -- located, : pressed",
    )
    axes[0].legend()
    for axis, scene in zip(axes[1:], SCENES, strict=True):
        axis.set(
            xlabel="CPU time for 10 ms (s)",
            ylabel="error of the ring's velocity",
            title=f"rollers, {scene}: - as it is, -- located",
        )
    for axis in axes:
        axis.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


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
        with open(options.csv, "w", newline="") as target:
            table = csv.DictWriter(target, [*rows[0]], lineterminator="\n")
            table.writeheader()
            table.writerows(
                {name: f"{x:.4g}" if isinstance(x, float) else x for name, x in row.items()} for row in rows
            )
    if options.figure:
        draw(rows, options.figure)


if __name__ == "__main__":
    main()
