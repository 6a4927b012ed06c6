"""Instants and strengths of the impulses on the ring in the model ``impulse``. Plain numpy.

McFadden and Smith (J. Sound Vib. 96, 1984, 69-82) assume an impulse at each passage of a roller over a point
defect, proportional to the load there, q(phi), and superpose the trains of several defects (98, 1985, 263-273).
They leave the scale of the impulses free. Here it follows from the load that a roller loses. Over the defect the
roller's force on the race is missing, which is equivalent to a force P q(phi) on the ring against e_r. At the
distance s from the defect's centre

    (1 - kappa) P = 1 - sum_g w_g max(1 - h_g(s)/delta + kappa P/n, 0)^n,      J = q(phi)/v integral of P ds

h_g: roller path over the defect's group g; delta(phi): approach of both contacts of the roller together; v: speed
at which the contact moves over the defect; kappa = k (cos^2 phi/K_x + sin^2 phi/K_y): the share of the roller's
stiffness k = n q/delta in that of the ring. The terms in kappa subtract this share while the roller is unloaded
(with K_x = K_y = inf they vanish). For a fully unloaded roller P = 1/(1 - kappa), 1.45 for an NF308 without
clearance. A defect as long as the roller, much wider than sqrt(2 R delta) and deeper than delta, gives J = P q
w/v, the force P q over the time of crossing; a shorter, narrower or shallower defect gives less. The impulse acts
at the midpoint of the crossing, which is accurate for frequencies far below v/w.

Neglected: inertia during the crossing, the impact of the returning roller (its impulse is almost only that of the
load, because the roller is light), and slip.
"""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from bearingsim.core.defects.closed_forms import roller_drop
from bearingsim.core.defects.envelope import path_drop
from bearingsim.core.defects.pairs import GROUP_WEIGHT, INNER, ON_INNER, RollerDefectPair
from bearingsim.core.parameters import Bearing

WIDTH_SAMPLES = 200  # samples of the lost load over half a defect
NEWTON_STEPS = 8  # sufficient because the function is convex and the iteration starts above its root
MAX_STIFFNESS_SHARE = 0.5  # upper bound of kappa; a ring supported mainly by one roller would fall without it


class LoadZone(NamedTuple):
    """Load distribution q(phi) = q_0 [1 - (1 - cos phi)/(2 epsilon)]^n, zero where the bracket is negative.

    q_0: largest load of a roller (N); delta_0: total approach of its two contacts (m); epsilon: load zone
    parameter, 1/2 without clearance, less with it, more with preload; n: exponent of the contact, 10/9 for a line,
    3/2 for a point; axis: angle of the most loaded position from the load line (rad); K_x, K_y: the ring's
    stiffness on rollers and bracket (N/m), inf to neglect its reduction while a roller is unloaded. Source:
    Stribeck; McFadden and Smith 1984.
    """

    q_0: float
    delta_0: float
    epsilon: float
    n: float
    axis: float = 0.0
    K_x: float = inf
    K_y: float = inf


class ImpulseTrain(NamedTuple):
    """Impulses on the ring: times (n,) s, ascending; J_x, J_y (n,) N s, along the load line and across it."""

    times: np.ndarray
    J_x: np.ndarray
    J_y: np.ndarray


def approach(zone: LoadZone, phi: np.ndarray) -> np.ndarray:
    """Return the total approach (m) of both contacts of a roller at ``phi`` (rad), 0 outside the load zone."""
    return zone.delta_0 * np.maximum(1.0 - (1.0 - np.cos(phi - zone.axis)) / (2.0 * zone.epsilon), 0.0)


def load(zone: LoadZone, phi: np.ndarray) -> np.ndarray:
    """Return the load (N) of a roller at ``phi`` (rad from the load line)."""
    return zone.q_0 * (approach(zone, phi) / zone.delta_0) ** zone.n


def defect_passages(
    bearing: Bearing, pair: RollerDefectPair, start: float, end: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the instants (n,) in (start, end], s, of rollers over the defect's centre, and its angles (n,) rad.

    A defect of the outer race is passed Z times per revolution of the cage, always at its own angle; a defect of
    the inner race Z times per revolution of the ring relative to the cage, at the current angle of the ring; a
    defect of a roller once per race and revolution of the roller, at the current angle of the roller.
    """
    pass_angle = 2.0 * np.pi / bearing.Z
    if pair.carrier >= 0:
        contact_angle = np.pi if pair.side == INNER else 0.0  # from the roller's outermost point
        times = instants(pair.angle + contact_angle, 2.0 * np.pi, bearing.omega_b, start, end)
        return times, bearing.theta_0 + bearing.omega_c * times + pair.carrier * pass_angle
    if pair.carrier == ON_INNER:
        relative = bearing.omega_i - bearing.omega_c
        times = instants(bearing.theta_0 - pair.angle, pass_angle, relative, start, end)
        return times, pair.angle + bearing.omega_i * times
    times = instants(pair.angle - bearing.theta_0, pass_angle, bearing.omega_c, start, end)
    return times, np.full(len(times), pair.angle)


def instants(offset: float, period: float, speed: float, start: float, end: float) -> np.ndarray:
    """Return the instants t (n,) in (start, end], s, at which ``speed`` t is ``offset`` plus a multiple of
    ``period``."""
    low, high = (np.floor((speed * t - offset) / period) for t in (start, end))
    return (offset + period * np.arange(low + 1, high + 1)) / speed


def crossing_speed(bearing: Bearing, pair: RollerDefectPair) -> float:
    """Return the speed (m/s) at which a contact moves over the defect."""
    if pair.carrier >= 0:
        return pair.radius * bearing.omega_b
    if pair.carrier == ON_INNER:
        return pair.radius * (bearing.omega_i - bearing.omega_c)
    return pair.radius * bearing.omega_c


def stiffness_share(zone: LoadZone, phi: np.ndarray) -> np.ndarray:
    """Return kappa (n,), the share of a roller at ``phi`` (n,) rad in the ring's stiffness, at most
    ``MAX_STIFFNESS_SHARE``."""
    stiffness = zone.n * load(zone, phi) / approach(zone, phi)
    return np.minimum(stiffness * (np.cos(phi) ** 2 / zone.K_x + np.sin(phi) ** 2 / zone.K_y), MAX_STIFFNESS_SHARE)


def unloaded_width(pair: RollerDefectPair, delta: np.ndarray, kappa: np.ndarray, n: float) -> np.ndarray:
    """Return the integral of P over the defect (n,), m: the unloaded distance of rollers with approach ``delta`` >
    0 (n,) m."""
    s = ((np.arange(2 * WIDTH_SAMPLES) + 0.5) / WIDTH_SAMPLES - 1.0) * pair.half_width
    h = roller_drops(pair, s)
    delta, kappa = delta[:, None], kappa[:, None]
    P = np.repeat(1.0 / (1.0 - kappa), 2 * WIDTH_SAMPLES, axis=1)
    for _ in range(NEWTON_STEPS):
        excess, derivative = (1.0 - kappa) * P - 1.0, 1.0 - kappa
        for row, drop in zip(pair.groups, h, strict=True):
            load_share = np.maximum(1.0 - drop / delta + kappa * P / n, 0.0)
            force = row[GROUP_WEIGHT] * load_share ** (n - 1.0)
            excess, derivative = excess + force * load_share, derivative + force * kappa
        P = P - excess / derivative
    return 2.0 * pair.half_width * P.mean(axis=1)


def roller_drops(pair: RollerDefectPair, s: np.ndarray) -> list[np.ndarray]:
    """Return the drop (n,) m of a roller into each group at ``s`` (n,) m."""
    if pair.paths:
        return [path_drop(path, s)[0] for path in pair.paths]
    return [np.array([roller_drop(np.array(row), x, pair.R)[0] for x in s]) for row in pair.groups]


def impulse_strengths(bearing: Bearing, zone: LoadZone, pair: RollerDefectPair, phi: np.ndarray) -> np.ndarray:
    """Return the impulse J (n,) N s of the load that a roller at ``phi`` (n,) rad loses over the defect; 0 outside
    the load zone."""
    angles, inverse = np.unique(phi, return_inverse=True)
    J, loaded = np.zeros(len(angles)), approach(zone, angles) > 0.0
    loaded_angles = angles[loaded]
    width = unloaded_width(pair, approach(zone, loaded_angles), stiffness_share(zone, loaded_angles), zone.n)
    J[loaded] = load(zone, loaded_angles) * width / crossing_speed(bearing, pair)
    return J[inverse]


def make_train(
    bearing: Bearing, zone: LoadZone, pairs: Sequence[RollerDefectPair], start: float, end: float
) -> ImpulseTrain:
    """Return the impulses at all passages of rollers over the defects in (start, end], s."""
    parts = [defect_impulses(bearing, zone, pair, start, end) for pair in pairs]
    return merge_trains(parts)


def defect_impulses(
    bearing: Bearing, zone: LoadZone, pair: RollerDefectPair, start: float, end: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the instants (n,) s, angles (n,) rad and strengths (n,) N s of one defect's impulses."""
    times, phi = defect_passages(bearing, pair, start, end)
    return times, phi, impulse_strengths(bearing, zone, pair, phi)


def make_random_train(
    bearing: Bearing,
    zone: LoadZone,
    pairs: Sequence[RollerDefectPair],
    start: float,
    end: float,
    generator: np.random.Generator,
    spacing: float = 50e-6,
) -> ImpulseTrain:
    """Return the train of ``make_train`` with each impulse divided among the asperities of a rough defect.

    After Behzad, Bastami and Mba (J. Vib. Acoust. 133, 2011, 031011), who attribute the vibration of a damaged
    bearing to random impacts of asperities. Over a defect of width w the impulse J becomes N = w/``spacing``
    impulses (rounded, at least 1), uniformly distributed over the crossing, with exponentially distributed
    strengths of mean J/N: their sum has the mean J and the standard deviation J/sqrt(N). Neglected: the heights
    and stiffness of asperities (represented only by ``spacing``, in m), and asperities of healthy surfaces.

    The same generator state gives the same train, and a longer train begins with the shorter one.
    """
    parts = []
    for pair, rng in zip(pairs, generator.spawn(len(pairs)), strict=True):
        times, phi, J = defect_impulses(bearing, zone, pair, start, end)
        width = 2.0 * pair.half_width
        N = max(1, round(width / spacing))
        u = rng.random((len(times), N, 2))
        delay = (u[:, :, 0] - 0.5) * width / crossing_speed(bearing, pair)
        strength = J[:, None] / N * -np.log1p(-u[:, :, 1])
        parts.append(((times[:, None] + delay).ravel(), np.repeat(phi, N), strength.ravel()))
    return merge_trains(parts)


def merge_trains(parts: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> ImpulseTrain:
    """Merge all (times, angles, strengths) into one train; each impulse acts on the ring against e_r at its
    angle."""
    times, phi, J = (np.concatenate([np.zeros(0), *(part[n] for part in parts)]) for n in range(3))
    order = np.argsort(times, kind="stable")
    return ImpulseTrain(times[order], (-J * np.cos(phi))[order], (-J * np.sin(phi))[order])
