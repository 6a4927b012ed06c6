"""The models and the steppers of touch_down.py."""

from collections import namedtuple
from math import inf, sqrt
from typing import Any, NamedTuple

import own_cache  # noqa: F401  (before the core is imported)

from bearingsim.core import layout as lay
from bearingsim.core.defects.jumps import JUMP_GAP, next_jump
from bearingsim.core.defects.on_roller import roller_at_defect
from bearingsim.core.jit import jit
from bearingsim.core.methods.dop853 import Dop853
from bearingsim.core.methods.dormand_prince import DormandPrince
from bearingsim.core.methods.interface import prepare, step
from bearingsim.core.methods.nystrom import Nystrom
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.interface import accelerations, degrees_of_freedom, state_width, update_extremes
from bearingsim.core.models.rollers import Rollers
from bearingsim.core.parameters import Bearing

NAMES = {
    "verlet": Verlet,
    "rk4": RungeKutta4,
    "nystrom": Nystrom,
    "dormand-prince": DormandPrince,
    "dop853": Dop853,
}
FIXED, ADAPTIVE = ("verlet", "rk4", "nystrom"), ("dormand-prince", "dop853")
MASS, STEEL, PUSH, SPEED = 0.010654, 1.57e9, 2.0, 10e-3
OMEGA = 1.5e5  # 1/s: about that of the contact in motion; the scale of position against velocity
CLOSE = 1e-9  # s: a contact this near is advanced directly to its touch-down


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
    y[lay.RADIAL_A] = (-model.push + model.k * max(-y[lay.RADIAL], 0.0) ** model.m) / MASS


for _type in (Contact, LocatedContact):
    state_width.register(_type)(lambda model: lay.FIRST_LANE + 8)
    degrees_of_freedom.register(_type)(lambda model: (1, 0))
    update_extremes.register(_type)(lambda model, y: None)
    accelerations.register(_type)(_contact)
next_jump.register(Contact)(lambda model, t, y: inf)
next_jump.register(LocatedContact)(
    lambda model, t, y: (
        t + until_zero(y[lay.RADIAL], y[lay.RADIAL_V], y[lay.RADIAL_A]) if y[lay.RADIAL] > 0.0 else inf
    )
)


# 2. The bearing


LocatedRollers = namedtuple("LocatedRollers", Rollers._fields)  # type: ignore[misc]
"""``Rollers`` whose contacts are known to open and close."""
BlindRollers = namedtuple("BlindRollers", Rollers._fields)  # type: ignore[misc]
"""``Rollers`` of which nothing is known ahead, not even when they pass a cusp."""
KNOWN: dict[str, Any] = {"nothing": BlindRollers, "cusps": Rollers, "contacts": LocatedRollers}


@jit
def plain(model):
    """The model as the package has it."""
    return Rollers(*model)


for _model in (LocatedRollers, BlindRollers):
    state_width.register(_model)(lambda model: state_width(plain(model)))
    degrees_of_freedom.register(_model)(lambda model: degrees_of_freedom(plain(model)))
    update_extremes.register(_model)(lambda model, y: update_extremes(plain(model), y))
    accelerations.register(_model)(lambda model, t, y: accelerations(plain(model), t, y))
    roller_at_defect.register(_model)(lambda model, d, t, y: roller_at_defect(plain(model), d, t, y))
next_jump.register(BlindRollers)(lambda model, t, y: inf)


@next_jump.register(LocatedRollers)
def _next_jump(model, t, y):
    soonest = inf
    for j in range(model.bearing.Z):
        ring = y[lay.ACCELERATION + lay.X] * y[lay.COS + j] + y[lay.ACCELERATION + lay.Y] * y[lay.SIN + j]
        soonest = min(soonest, until_zero(y[lay.DELTA_O + j], y[lay.V_O + j], y[lay.RADIAL_A + j] - ring))
        soonest = min(soonest, until_zero(y[lay.DELTA_I + j], y[lay.V_I + j], -y[lay.RADIAL_A + j]))
    y[lay.NEXT_STOP] = t  # may be that of a contact, not of a jump
    return min(closing_in(t, soonest), next_jump(plain(model), t, y))


# Steps


def stepper(parameters: Any) -> Any:
    """A fixed-step method that ends its steps on what ``next_jump`` knows of."""

    @jit
    def located(method, model, t, y):
        end = t + method.h
        while end - t > JUMP_GAP:
            wait = next_jump(model, t, y) - t
            if wait <= JUMP_GAP:
                for k in range(state_width(model)):
                    y[lay.VELOCITY + k] += 2.0 * JUMP_GAP * y[lay.ACCELERATION + k]
                    y[k] += 2.0 * JUMP_GAP * y[lay.VELOCITY + k]
                t += 2.0 * JUMP_GAP
                accelerations(model, t, y)
            else:
                part = min(end - t, wait)
                step(parameters(part), model, t, y)
                y[lay.STEPS_TAKEN] += 1.0
                t += part

    @jit
    def go(method, model, first, y, stride, out):
        for n in range(len(out)):
            for k in range(stride):
                located(method, model, (first + n * stride + k) * method.h, y)
            out[n, 0], out[n, 1] = y[lay.VELOCITY + lay.X], y[lay.VELOCITY + lay.Y]

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
        out[n, 0], out[n, 1] = y[lay.VELOCITY + lay.X], y[lay.VELOCITY + lay.Y]


LOCATED = {name: stepper(NAMES[name]) for name in FIXED}
