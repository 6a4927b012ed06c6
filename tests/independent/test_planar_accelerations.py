"""Accelerations of `planar` at random states against the equations on the pages: no motion, no chaos."""

from dataclasses import replace

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from tests.independent.solver import MAX_GROUPS, Contacts
from tests.independent.solver_arrays import planar_bodies, prepare
from tests.independent.solver_planar import planar_rates, shaft_motion
from tests.independent.solver_scenes import MM, TRACTION, UM, UNEQUAL, Defect, Scene, Wave, case_of

TIME = 3e-3
DEFECTS = (
    Defect("triangular", 7 * MM, 4 * MM, 2 * UM, 10.0),
    Defect("triangular", 8 * MM, 4 * MM, 3 * UM, 88.0, "inner", 1 * MM),
    Defect("triangular", 12 * MM, 4 * MM, 2 * UM, 86.0, "roller", roller=2),
)
"""Shallow and wide, where rollers are after TIME."""
WAVES = (Wave("outer", 14, 0.5 * UM), Wave("inner", 9, 0.7 * UM, 50.0), Wave("roller", 3, 0.3 * UM, 10.0))
EVERYTHING = Scene(
    model="planar", load=500.0, load_across=70.0, clearance=-4 * UM, shaft=(2e7, 1.2, 300.0),
    unbalance=(50e-6, 30.0), torsion=(1e4, 0.3),
    ramp=(2400.0, 0.03), drag=(("land", "inner"), ("oil_fraction", 0.2)), gravity=True,
    defects=DEFECTS,
)  # fmt: skip
SETUPS = {
    "centred, traction": replace(EVERYTHING, friction=TRACTION),
    "on outer ring": replace(EVERYTHING, guide="outer-ring", damping=("hunt-crossley", 30.0)),
    "on inner ring": replace(EVERYTHING, guide="inner-ring", damping=("hunt-crossley", 30.0), drag=()),
    "on rollers, form": replace(EVERYTHING, waves=WAVES, diameters=UNEQUAL, guide="rollers"),
}
"""Scenes of all effects."""


def random_state(s: Scene, seed: int) -> np.ndarray:
    """State of ``planar_rates``: micrometres and cm/s at the races, pockets and guide closed in part."""
    b, bodies = prepare(s)[0], planar_bodies(s, prepare(s)[0])
    theta_i, omega_i, _ = shaft_motion(TIME, b, bodies)
    rng, Z, orbit = np.random.default_rng(seed), b.Z, (1 - b.gamma) / 2
    spin = orbit - (1 - b.gamma**2) / (2 * b.gamma)
    y = np.zeros(16 + 6 * Z)
    y[0:2], y[2:4] = rng.normal(0.0, 2e-6, 2), rng.normal(0.0, 2e-2, 2)
    y[4:6] = rng.normal(0.0, (1e-3, 0.3)) if s.torsion else 0.0
    y[6], y[7] = b.theta_0 + orbit * theta_i + rng.normal(0.0, 1e-3), orbit * omega_i + rng.normal(0.0, 1.0)
    if s.guide != "centred":
        y[8:10], y[10:12] = rng.normal(0.0, 3e-4, 2), rng.normal(0.0, 2e-2, 2)
    if s.shaft:
        y[12:14], y[14:16] = rng.normal(0.0, 2e-6, 2), rng.normal(0.0, 2e-2, 2)
    y[16::6], y[17::6] = rng.normal(0.0, 3e-6, Z), rng.normal(0.0, 2e-2, Z)
    y[18::6] = y[6] + 2 * np.pi * np.arange(Z) / Z + rng.normal(0.0, 3e-3, Z)
    y[19::6] = y[7] + rng.normal(0.0, 1.0, Z)
    y[20::6] = b.theta_0 + 2 * np.pi * np.arange(Z) / Z + spin * theta_i + rng.normal(0.0, 0.02, Z)
    y[21::6] = spin * omega_i + rng.normal(0.0, 8.0, Z)
    return y


def relative(s: Scene, y: np.ndarray, rates: bool) -> dict[tuple, np.ndarray]:
    """Cells of the package's state and its values: angles less the kinematic ones (P1)."""
    b, bodies = prepare(s)[0], planar_bodies(s, prepare(s)[0])
    shaft = shaft_motion(TIME, b, bodies)[1 if rates else 0]
    orbit, ahead = (1 - b.gamma) / 2, 1 if rates else 0
    spin, pockets = orbit - (1 - b.gamma**2) / (2 * b.gamma), 2 * np.pi * np.arange(b.Z) / b.Z
    theta_0 = 0.0 if rates else b.theta_0
    return {
        (lay.X, 2): y[0 + 2 * ahead : 2 + 2 * ahead],
        (lay.PSI, 1): y[4 + ahead],
        (lay.PHI_C, 1): y[6 + ahead] - theta_0 - orbit * shaft,
        (lay.X_C, 2): y[8 + 2 * ahead : 10 + 2 * ahead],
        (lay.X_I, 2): y[12 + 2 * ahead : 14 + 2 * ahead],
        (lay.RADIAL, b.Z): y[16 + ahead :: 6],
        (lay.EPS, b.Z): y[18 + ahead :: 6] - y[6 + ahead] - (0.0 if rates else pockets),
        (lay.SPIN, b.Z): y[20 + ahead :: 6] - theta_0 - (0.0 if rates else pockets) - spin * shaft,
    }


def rates_of(s: Scene, seed: int, contacts: Contacts) -> tuple[np.ndarray, np.ndarray]:
    """Rates of the random state and forces, (5, Z)."""
    y, b = random_state(s, seed), prepare(s)[0]
    dy, forces = np.zeros(len(y)), np.zeros((5, b.Z))
    planar_rates(TIME, y, b, contacts, planar_bodies(s, b), dy, np.zeros((MAX_GROUPS, 5)), forces)
    return dy, forces


def differences(s: Scene, seed: int) -> dict[str, float]:
    """Largest difference of forces, slips and accelerations, each over its largest value."""
    y, (b, contacts, *_) = random_state(s, seed), prepare(s)
    dy, forces = rates_of(s, seed, contacts)
    model = assemble.model(case_of(s))
    buffer = assemble.empty_buffer(model)
    for block, rates in ((lay.POSITION, False), (lay.VELOCITY, True)):
        for (cell, size), values in relative(s, y, rates).items():
            buffer[block + cell : block + cell + size] = values
    start_at_rest(model, TIME, buffer)
    alpha = shaft_motion(TIME, b, planar_bodies(s, b))[2]
    orbit, a = (1 - b.gamma) / 2, lay.ACCELERATION
    spin = orbit - (1 - b.gamma**2) / (2 * b.gamma)
    closed = np.where(forces[:2] > 0.0, 1.0, 0.0)
    pairs = {
        "forces of the races": (forces[:2], (lay.Q_O, lay.Q_I)),
        "slips": (closed * forces[2:4], (lay.SLIP_O, lay.SLIP_I)),
        "forces of the pockets": (-forces[4:], (lay.Q_P,)),
        "ring": (dy[2:4], (a + lay.X,)),
        "rotation of the ring": (dy[5:6], (a + lay.PSI,)),
        "rotation of the cage": (dy[7:8] - orbit * alpha, (a + lay.PHI_C,)),
        "cage": (dy[10:12], (a + lay.X_C,)),
        "inner ring": (dy[14:16], (a + lay.X_I,)),
        "radial": (dy[17::6], (lay.RADIAL_A,)),
        "along the cage": (dy[19::6] - dy[7], (lay.EPS_A,)),
        "spin": (dy[21::6] - spin * alpha, (lay.SPIN_A,)),
    }
    result = {}
    for name, (expected, cells) in pairs.items():
        expected = np.atleast_2d(expected)
        values = np.array([buffer[cell : cell + expected.shape[1]] for cell in cells])
        values = closed * values if name == "slips" else values
        result[name] = float(np.abs(values - expected).max() / (np.abs(expected).max() or 1.0))
    return result


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", SETUPS)
def test_accelerations(name, seed):
    """Within 1e-7: the solver's path is tabulated, 4e-9 was measured where a roller passes from rim to wall.

    With form within 1e-4: the package interpolates its waves in a table (1e-5 was measured).
    """
    s = SETUPS[name]
    assert max(differences(s, seed).values()) < (1e-4 if s.waves else 1e-7)


def test_every_effect_acts():
    """In some of the states each defect presses on a roller, and pockets and guide on the cage."""
    defects, pockets, guides = np.zeros(3), 0.0, {}
    for name, s in SETUPS.items():
        contacts = prepare(s)[1]
        without = contacts._replace(head=np.zeros((0, 5)), span=np.zeros((0, 2), int))
        for seed in range(3):
            rates, forces = rates_of(s, seed, contacts)
            pockets = max(pockets, np.abs(forces[4]).max())
            guides[name] = max(guides.get(name, 0.0), np.abs(rates[10:12]).max())
            for d in range(3):
                part = slice(d, d + 1)
                only = contacts._replace(
                    head=contacts.head[part], span=contacts.span[part], rest=contacts.rest[part]
                )
                change = rates_of(s, seed, only)[0] - rates_of(s, seed, without)[0]
                defects[d] = max(defects[d], np.abs(change).max())
    assert defects.min() > 1.0
    assert pockets > 1.0
    assert min(size for name, size in guides.items() if not name.startswith("centred")) > 10.0
