"""Independent solution of a lubricated line contact and of its response to an oscillation: no code is shared.

The equations (isothermal, Newtonian, smooth, flooded; both surfaces roll at the mean speed u, x along u, so the
oil comes in at negative x). q is the flow per length, V the rate at which the bodies approach:

    Reynolds      q = u rho h - rho h^3/(12 eta) dp/dx,    dq/dx + d(rho h)/dt = 0
    gap           h = h_0(t) + x^2/(2 R) - 2/(pi E*) int p(x') ln|x - x'| dx'    (two half-spaces in plane strain)
    load          int p dx = Q/L
    ends          p = 0 far upstream; p = dp/dx = 0 where the oil leaves, at an unknown position
    viscosity     Roelands, with the slope alpha at p = 0; density after Dowson and Higginson

Lengths along the film are in half widths b of Hertz's dry strip, gaps in b^2/R, pressures in Hertz's largest.

**Discretisation.** Pressure is linear between nodes and zero at both ends, the deformation is exact. Flow is taken
at the middles of the cells. What the oil carries there, rho h, is extrapolated from the two nodes upstream (rho h
at the middles themselves would not see a pressure that alternates from node to node); the pressure's part takes
the mean of 1/eta over the cell. At rest the flow is the same through all cells, q: "flow = q" with q unknown. All
nodes scale with the unknown position of the exit. Newton's method solves for pressures, h_0, q and exit at once.

**Oscillation.** To first order of a small amplitude the condition p = dp/dx = 0 at a moving exit is dp = 0 at the
exit at rest, where p and its slope vanish. The perturbed flow obeys d(q)/dx = -i omega d(rho h) over the cells
about the inner nodes, dp = 0 at both ends: a linear system of the complex amplitudes of pressure.

**Series.** The film's approach of two half-spaces has no datum in plane strain. Only the difference to a dry
contact (Hertz) of the same datum has a meaning: film less dry is a compliance that is put in series with the dry
contact's 1/k, k from the elastic law in use.

**Convergence.** c (N s/m) of slow oscillations and film carried (um) over ``cells``; L = 12 mm, R = 7.1 mm,
0.03 Pa s, 20 1/GPa, 2.96 m/s:

    cells    150 N            500 N            3500 N
    100      941.6  0.6380    1054.5 0.5972    615.4 0.5009
    200      942.3  0.6382    1053.6 0.5975    612.4 0.5020
    400      942.2  0.6383    1053.3 0.5976

At 1.7 to 2.0 GPa 100, 200 and 400 cells differ by 1 to 7 %, 0.3 to 1 %. Oscillations whose wave in the film, 2 pi
u/omega, is shorter than 20 cells are not resolved.
"""

from math import log, pi, sqrt
from typing import NamedTuple

import numpy as np

FAR, GROWTH = 30.0, 1.04  # the inlet, in exits upstream; of the cells towards it
MARTIN = 4.896  # h_0 = 4.896 eta u R/(Q/L) of rigid cylinders and an isoviscous oil
EXIT = 0.47513  # and its exit over sqrt(2 R h_0)
STIFF = 500.0
GAUSS = np.polynomial.legendre.leggauss(6)
P_0 = 1.962e8  # Pa, of Roelands' law
ROELANDS = 9.67  # ln of the viscosity (Pa s) at P_0's pole, changed in sign


class Contact(NamedTuple):
    """Bodies and oil, SI units; ``E_star`` = E/(2 (1 - nu^2)), ``u`` mean of both surfaces."""

    Q: float
    L: float
    R: float
    E_star: float
    eta: float
    alpha: float
    u: float

    @property
    def b(self):
        return sqrt(4.0 * self.Q * self.R / (pi * self.L * self.E_star))

    @property
    def hertz(self):
        return 2.0 * self.Q / (pi * self.b * self.L)

    @property
    def compliance(self):
        """Of the scaled approach over the scaled load (pi/2), in m/N."""
        return self.b / (self.R * self.hertz * self.L)

    @property
    def gap(self):
        """Unit of the gap, m."""
        return self.b**2 / self.R


class Film(NamedTuple):
    """A solution at rest: ``x`` (nodes, m), ``p`` (Pa), ``h`` (m, at the nodes), ``flow`` = rho h/rho_0 at the
    exit (m: the film that is carried through), and what the oscillation needs."""

    contact: Contact
    unit: np.ndarray  # nodes over the exit's place
    unknown: np.ndarray
    x: np.ndarray
    p: np.ndarray
    h: np.ndarray
    flow: float

    @property
    def thinnest(self):
        return self.h.min()

    @property
    def central(self):
        """Gap where the pressure is largest: there the flow is u rho h."""
        return self.h[np.argmax(self.p)]


def nodes(cells, far=FAR, growth=GROWTH):
    """Nodes from ``-far`` to 1, the exit: ``cells`` of even length between -1 and 1, upstream of -1.25 growing."""
    step, positions = 2.0 / cells, [1.0]
    while positions[-1] > -far:
        step *= growth if positions[-1] < -1.25 else 1.0
        positions.append(positions[-1] - step)
    return np.array(positions[::-1])


def deformation(points, node):
    """-(1/pi) int ln|x - x'| of unit hats on the inner nodes (a column each), at the points ``at``."""

    def second_integral(d):  # second integral of ln|d| over d
        distance = np.where(d == 0.0, 1.0, np.abs(d))
        return d * d * (0.5 * np.log(distance) - 0.75)

    G = second_integral(points[:, None] - node[None, :])
    slope = np.diff(G, axis=1) / np.diff(node)[None, :]
    return -np.diff(slope, axis=1) / pi


class Mesh(NamedTuple):
    """Matrices on the scaled nodes."""

    unit: np.ndarray
    middle: np.ndarray
    at_nodes: np.ndarray  # deformation, a row each for all nodes, a column each for the inner ones
    at_middles: np.ndarray
    weight: np.ndarray  # of the inner nodes, for integrals


def mesh(unit):
    middle = (unit[1:] + unit[:-1]) / 2.0
    weight = (unit[2:] - unit[:-2]) / 2.0
    return Mesh(unit, middle, deformation(unit, unit), deformation(middle, unit), weight)


def upwind(m, values):
    """From all nodes to the middles, by the two nodes upstream of each (the first: by its ends)."""
    cell = np.diff(m.unit)
    share = (cell[1:] / cell[:-1] / 2.0).reshape((-1,) + (1,) * (values.ndim - 1))
    first = (values[:1] + values[1:2]) / 2.0
    return np.concatenate([first, values[1:-1] + share * (values[1:-1] - values[:-2])])


def fluidity(contact, P):
    """1/eta over 1/eta_0, and d(ln eta)/dP, at the scaled pressure P; below zero as at zero."""
    p = np.maximum(P, 0.0) * contact.hertz
    thick = log(contact.eta) + ROELANDS
    z = contact.alpha * P_0 / thick
    exponent = thick * (np.power(1.0 + p / P_0, z) - 1.0)
    slope = thick * z * np.power(1.0 + p / P_0, z - 1.0) * contact.hertz / P_0
    return np.exp(-np.minimum(exponent, 60.0)), np.where(P > 0.0, slope, 0.0)


def mean_fluidity(contact, full):
    """Mean of 1/eta over each cell, where pressure is linear, and its derivatives by the pressures at its ends."""
    mean, left, right = 0.0, 0.0, 0.0
    for position, weight in zip((GAUSS[0] + 1.0) / 2.0, GAUSS[1] / 2.0, strict=True):
        fluidity_, slope = fluidity(contact, full[:-1] + position * np.diff(full))
        mean, left, right = (
            mean + weight * fluidity_,
            left - weight * (1.0 - position) * fluidity_ * slope,
            right - weight * position * fluidity_ * slope,
        )
    return mean, left, right


def density(contact, P):
    """rho over rho_0 and its derivative by P: (5.9e8 + 1.34 p)/(5.9e8 + p)."""
    p = np.maximum(P, 0.0) * contact.hertz
    slope = 0.34 * 5.9e8 / (5.9e8 + p) ** 2 * contact.hertz
    return (5.9e8 + 1.34 * p) / (5.9e8 + p), np.where(P > 0.0, slope, 0.0)


def gaps(matrix, unit, weight, P, H_0, exit):
    """Return the gap at the nodes ``unit`` of a mesh stretched by ``exit``, with its derivatives.

    ln(s x) = ln s + ln x.
    """
    by_P = exit * matrix - exit * log(exit) / pi * weight[None, :]
    by_exit = exit * unit**2 + matrix @ P - (log(exit) + 1.0) / pi * (weight @ P)
    return H_0 + (exit * unit) ** 2 / 2.0 + by_P @ P, by_P, by_exit


class Flow(NamedTuple):
    """Flow q through each cell over u b^2/R, and what is carried, rho H at the nodes, with their derivatives."""

    q: np.ndarray
    by_P: np.ndarray
    by_H: np.ndarray  # by H_0
    by_exit: np.ndarray
    content: np.ndarray
    content_by_P: np.ndarray
    content_by_H: np.ndarray
    content_by_exit: np.ndarray


def flows(contact, m, P, H_0, exit):
    lam = 12.0 * contact.eta * contact.u * contact.R**2 / (contact.b**3 * contact.hertz)
    full = np.concatenate([[0.0], P, [0.0]])
    inner = np.arange(len(P))

    H, H_by_P, H_by_exit = gaps(m.at_nodes, m.unit, m.weight, P, H_0, exit)
    rho, rho_slope = density(contact, full)
    content, content_by_P, content_by_exit = rho * H, rho[:, None] * H_by_P, rho * H_by_exit
    content_by_P[inner + 1, inner] += (rho_slope * H)[1:-1]

    H, H_by_P, H_by_exit = gaps(m.at_middles, m.middle, m.weight, P, H_0, exit)
    thin, thin_left, thin_right = mean_fluidity(contact, full)
    dense, dense_slope = density(contact, (full[1:] + full[:-1]) / 2.0)
    length = exit * np.diff(m.unit)
    cube, gradient = dense * H**3 * thin / lam, np.diff(full) / length
    q = upwind(m, content) - cube * gradient
    by_H = -3.0 * cube / H * gradient  # of the pressure's part
    by_P = upwind(m, content_by_P) + by_H[:, None] * H_by_P
    compress = dense_slope / dense / 2.0
    by_P[inner, inner] -= (cube * (gradient * (compress + thin_right / thin) + 1.0 / length))[:-1]
    by_P[inner + 1, inner] -= (cube * (gradient * (compress + thin_left / thin) - 1.0 / length))[1:]
    by_exit = upwind(m, content_by_exit) + by_H * H_by_exit + cube * gradient / exit
    return Flow(q, by_P, upwind(m, rho) + by_H, by_exit, content, content_by_P, rho, content_by_exit)


def newton(contact, m, P, H_0, q, exit, tolerance=1e-9, steps=25):
    """Pressures, H_0, flow and exit from a guess; None if it does not converge."""
    n = len(P)
    A, f = np.zeros((n + 3, n + 3)), np.zeros(n + 3)
    A[: n + 2, n + 1] = -1.0
    for _ in range(steps):
        flow = flows(contact, m, P, H_0, exit)
        A[: n + 1, :n], A[: n + 1, n], A[: n + 1, n + 2] = flow.by_P, flow.by_H, flow.by_exit
        f[: n + 1] = flow.q - q
        A[n + 1, :n], A[n + 1, n], A[n + 1, n + 2] = flow.content_by_P[-1], 1.0, flow.content_by_exit[-1]
        f[n + 1] = flow.content[-1] - q  # dp/dx = 0 where the oil leaves
        A[n + 2, :n], A[n + 2, n + 2] = exit * m.weight, m.weight @ P
        f[n + 2] = exit * (m.weight @ P) - pi / 2.0
        d = np.linalg.solve(A, -f)
        if not np.all(np.isfinite(d)):
            return None
        largest = max(np.abs(d[:n]).max() / 0.3, abs(d[n + 2]) / (0.2 * exit), abs(d[n + 1]) / (0.5 * abs(q)), 1.0)
        P, H_0, q, exit = (
            P + d[:n] / largest,
            H_0 + d[n] / largest,
            q + d[n + 1] / largest,
            exit + d[n + 2] / largest,
        )
        if largest == 1.0 and np.abs(d).max() < tolerance * (1.0 + abs(H_0)):
            return P, H_0, q, exit
    return None


def light_contact(contact):
    """The contact under a load so small that its bodies stay rigid: the gap is ``STIFF`` b^2/R."""
    return contact._replace(
        Q=contact.L * sqrt(MARTIN * contact.eta * contact.u * contact.R * pi * contact.E_star / (4.0 * STIFF))
    )


def rigid(contact, m):
    """Guess of a rigid contact: P, H_0, flow, exit: dp/dx = 12 eta u (h - h_exit)/h^3, h = h_0 + x^2/(2 R)."""
    H = STIFF
    exit = EXIT * sqrt(2.0 * H)
    gap = H + (exit * m.middle) ** 2 / 2.0
    slope = (gap - H * (1.0 + EXIT**2)) / gap**3
    P = np.cumsum(exit * np.diff(m.unit) * slope)[:-1]
    return P * pi / 2.0 / (exit * m.weight @ P), H, H * (1.0 + EXIT**2), exit


def at_rest(contact, cells=100, far=FAR, growth=GROWTH):
    """The film at rest, by steps of load from a rigid contact; each is extrapolated from the two before."""
    m = mesh(nodes(cells, far, growth))
    state = light_contact(contact)
    if contact.Q < state.Q:
        raise ValueError("so light a contact is rigid")
    solution = newton(state, m, *rigid(state, m))
    if solution is None:
        raise ArithmeticError("no rigid film")
    previous, ratio, last_factor = None, 1.5, 1.0
    while state.Q < contact.Q:
        factor = min(ratio, contact.Q / state.Q)
        trial = state._replace(Q=contact.Q if factor == contact.Q / state.Q else state.Q * factor)
        guess = solution
        if previous is not None:
            share = log(factor) / log(last_factor)
            guess = tuple(new + share * (new - old) for new, old in zip(solution, previous, strict=True))
        result = newton(trial, m, *guess)
        if result is None:
            ratio = 1.0 + (factor - 1.0) / 2.0
            previous = None if ratio < 1.02 else previous
            if ratio < 1.001:
                raise ArithmeticError(f"no film at {trial}")
            continue
        previous, solution, last_factor, state = solution, result, factor, trial
        ratio = min(1.0 + 1.5 * (ratio - 1.0), 2.0)
    return finish(contact, m.unit, solution)


def finish(contact, unit, solution):
    P, H_0, q, exit = solution
    m = mesh(unit)
    full = np.concatenate([[0.0], P, [0.0]])
    h, _, _ = gaps(m.at_nodes, unit, m.weight, P, H_0, exit)
    return Film(
        contact,
        unit,
        np.append(P, [H_0, exit]),
        exit * unit * contact.b,
        full * contact.hertz,
        h * contact.gap,
        q * contact.gap,
    )


def film_compliance(film, omega):
    """Complex compliance (m/N) of the film less that of the dry contact, at each of ``omega`` (rad/s)."""
    contact, m = film.contact, mesh(film.unit)
    P, H_0, exit = film.unknown[:-2], film.unknown[-2], film.unknown[-1]
    flow, length = flows(contact, m, P, H_0, exit), exit * m.weight
    stored_by_P = length[:, None] * flow.content_by_P[1:-1]
    stored_by_H = length * flow.content_by_H[1:-1]
    compliances = []
    for w in np.atleast_1d(omega):
        rate = 1j * w * contact.b / contact.u
        matrix = np.diff(flow.by_P, axis=0) + rate * stored_by_P
        change = np.linalg.solve(matrix, -np.diff(flow.by_H) - rate * stored_by_H)
        compliances.append(-1.0 / (length @ change) - log(2.0) / pi)
    return contact.compliance * np.array(compliances)


def loss_in_time(film, k, omega, amplitude, steps=120, cycles=2):
    """Energy (J) that film and dry contact ``k`` take up together in the last of ``cycles``, in time.

    Their approach swings by ``amplitude`` (m), which must be small: the nonlinear equations, but the exit as at
    rest, by the trapezium rule. Of the approach the bodies take Q/k, less what the dry contact's datum gave.
    """
    contact, m = film.contact, mesh(film.unit)
    P, H_0, exit = film.unknown[:-2], film.unknown[-2], film.unknown[-1]
    length, half = exit * m.weight, pi / omega / steps * contact.u / contact.b
    rest = flows(contact, m, P, H_0, exit)
    bodies = 1.0 / (k * contact.compliance) - log(2.0) / pi
    by_H = (length * rest.content_by_H[1:-1] + half * np.diff(rest.by_H))[:, None] * bodies * length[None, :]
    inverse = np.linalg.inv(length[:, None] * rest.content_by_P[1:-1] + half * np.diff(rest.by_P, axis=0) + by_H)
    swing, at_rest_load = amplitude / contact.gap, length @ P
    content, out, load, loss, nearer = rest.content, np.diff(rest.q), at_rest_load, 0.0, 0.0
    for step in range(1, steps * cycles + 1):
        before, last, nearer = load, nearer, swing * np.sin(2.0 * pi * step / steps)
        for _ in range(4):
            flow = flows(contact, m, P, H_0 - nearer + bodies * (length @ P - at_rest_load), exit)
            P = P - inverse @ (length * (flow.content - content)[1:-1] + half * (np.diff(flow.q) + out))
        content, out, load = flow.content, np.diff(flow.q), length @ P
        if step > steps * (cycles - 1):
            loss += (load + before - 2.0 * at_rest_load) / 2.0 * (nearer - last)
    return loss * contact.gap * contact.hertz * contact.b * contact.L


def stiffness(film, k, omega):
    """Complex stiffness (N/m) of the film in series with the dry contact's slope ``k`` (N/m): K + i omega c."""
    return 1.0 / (1.0 / k + film_compliance(film, omega))
