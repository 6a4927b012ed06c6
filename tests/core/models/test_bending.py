"""Flexible outer ring: against independent solutions, its power balance, and the rigid limit."""

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.assemble import bending
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.models.equilibrium import solve_initial_equilibrium
from bearingsim.core.models.interface import read_sensor
from bearingsim.core.parts import bending as core
from tests.independent import beam_ring, bent_rollers, bent_static, ring_elements
from tests.independent import rollers as nf308
from tests.scenes.bent_ring import HOUSING, PADS, POINTS, UNEVEN, case

# The beam


@pytest.mark.parametrize("n", [0, 2, 3, 5, 8, 20])
def test_harmonics_equal_the_independent_beam(n):
    """Mass, stiffness and frequency of the NF308's outer ring."""
    section = bending.ring_section(bending.ring_parameters(case()))
    harmonic = bending.harmonic(section, n)
    assert section.mass == pytest.approx(beam_ring.NF308.mass, rel=1e-12)
    assert harmonic.k == pytest.approx(1.0 / beam_ring.compliance(n), rel=1e-9)
    assert harmonic.omega == pytest.approx(2.0 * pi * beam_ring.frequencies(n)[0], rel=1e-9)


def test_the_beam_agrees_with_plane_stress_elements():
    """Frequencies n = 2 to 5 within 0.5 %, compliances n = 2 to 8 within 3 % (0.3 and 2.2 % measured)."""
    section = bending.ring_section(bending.ring_parameters(case()))
    reference_frequencies = ring_elements.free_frequencies()  # in pairs
    frequencies = [bending.harmonic(section, n).omega / (2.0 * pi) for n in (2, 3, 4, 5)]
    assert frequencies == pytest.approx(reference_frequencies[::2], rel=5e-3)
    stiffness = [bending.harmonic(section, n).k for n in range(2, 9)]
    assert 1.0 / np.array(stiffness) == pytest.approx(ring_elements.compliances(range(2, 9)), rel=3e-2)


# The right-hand side


@dataclass
class Scene:
    """A model and a random state near its equilibrium."""

    model: Any
    y: np.ndarray
    t: float


def random_scene(bearing_case: Case, seed: int, t: float = 0.0, spread: float = 1e-7) -> Scene:
    """Return a random state near equilibrium.

    Standard deviations: ``spread`` (m) of the positions, 1 mm/s of the velocities.
    """
    model, rng = assemble.model(bearing_case), np.random.default_rng(seed)
    y = assemble.empty_buffer(model)
    solve_initial_equilibrium(assemble.static_model(model), t, y)
    Z, H = model.bearing.Z, model.bending.harmonic_table.shape[1]
    cells = [lay.X, lay.Y, *range(lay.FIRST_LANE, lay.FIRST_LANE + Z)]
    for row, mass in ((lay.MODES_C, core.INVERSE_MASS_C), (lay.MODES_S, core.INVERSE_MASS_S)):
        cells += [row + i for i in range(H) if model.bending.harmonic_table[mass, i] > 0.0]
    y[[lay.POSITION + c for c in cells]] += spread * rng.normal(size=len(cells))
    y[[lay.VELOCITY + c for c in cells]] = 1e-3 * rng.normal(size=len(cells))
    start_at_rest(model, t, y)
    return Scene(model, y, t)


def reference_order(scene: Scene, block: int) -> np.ndarray:
    """Return a block of the state in the order of the reference: x, y, a_0, a_2, b_2, ..., then the rollers."""
    y, b = scene.y[block:], scene.model.bending
    modes = [y[lay.MODES_C + b.breathing_index]]
    for i in range(b.breathing_index):
        modes += [y[lay.MODES_C + i], y[lay.MODES_S + i]]
    return np.r_[y[lay.X], y[lay.Y], modes, y[lay.FIRST_LANE : lay.FIRST_LANE + scene.model.bearing.Z]]


@pytest.mark.parametrize("harmonics", [5, 8, 20])
@pytest.mark.parametrize(
    ("load", "reference_load"), [(None, bent_static.POINT), (PADS, bent_static.soft_pads(-45, 45))]
)
def test_accelerations_equal_the_independent_solution(harmonics, load, reference_load):
    """Agreement to 1e-9 of the largest acceleration of ring, harmonics or rollers, in and outside the slot.

    Without the bracket spring, because its anchor in the reference includes the centrifugal load of the rollers.
    """
    reference_scene = bent_static.Scene(last=harmonics, outside=reference_load, bracket=0.0)
    reference = bent_rollers.equations(
        reference_scene, bent_rollers.Motion(cap=bending.MAX_FREQUENCY / (2.0 * pi))
    )
    pass_time = 2.0 * pi / (nf308.Z * nf308.OMEGA_C)
    for seed, t in enumerate((0.0, 0.499 * pass_time, 0.51 * pass_time, 3.2e-3)):
        scene = random_scene(case(harmonics, load, rig={"bracket_stiffness": "0 N/m"}), seed, t)
        q, v, a = (reference_order(scene, block) for block in (lay.POSITION, lay.VELOCITY, lay.ACCELERATION))
        expected = reference.slope(t, np.r_[q, v])[len(q) :]
        for rows in (slice(0, 2), slice(2, -nf308.Z), slice(-nf308.Z, None)):
            assert a[rows] == pytest.approx(expected[rows], abs=1e-9 * np.abs(expected[rows]).max())


def spring_states(scene: Scene) -> dict[str, np.ndarray]:
    """Return compression (m), its rate, stiffness and damping of each spring, by a direct sum over harmonics."""
    y, b = scene.y, scene.model.bending
    cosines, sines, k, c, fit = b.springs.spring_table[:, : b.springs.transposed_shapes.shape[1]]
    angles = np.arctan2(sines, cosines)
    values = []
    for block in (lay.POSITION, lay.VELOCITY):
        total = y[block + lay.X] * cosines + y[block + lay.Y] * sines
        for i in range(b.breathing_index + 1):
            n = b.harmonic_table[core.ORDER, i]
            total += y[block + lay.MODES_C + i] * np.cos(n * angles) + y[block + lay.MODES_S + i] * np.sin(
                n * angles
            )
        carrier = b.springs.carrier
        values.append(
            total - y[block + lay.MODES_C + carrier] * cosines - y[block + lay.MODES_S + carrier] * sines
        )
    return {"compression": values[0] + fit, "rate": values[1], "k": k, "c": c}


@pytest.mark.parametrize(
    "load", [None, PADS, POINTS, HOUSING, HOUSING | {"fit": "2 um"}, HOUSING | {"fit": "-2 um"}]
)
def test_power_balance(load):
    """The power into masses, springs and dampers equals that of load, cage and centrifugal force, to 1e-9.

    At random states; on points and on a housing without interference, with some springs in contact and others not.
    """
    partly_compressed = 0
    for seed in range(6):
        scene = random_scene(case(8, load, defect=None), seed, spread=1e-6)
        y, model = scene.y, scene.model
        b, modes = model.bearing, model.bending.harmonic_table
        v = {cell: y[lay.VELOCITY + cell] for cell in (lay.X, lay.Y)}
        kinetic = b.m_o * sum(v[cell] * y[lay.ACCELERATION + cell] for cell in v)
        stored = supplied = dissipated = 0.0
        for row, mass, f in (
            (lay.MODES_C, core.INVERSE_MASS_C, core.LOAD_C),
            (lay.MODES_S, core.INVERSE_MASS_S, core.LOAD_S),
        ):
            present = modes[mass] > 0.0
            m = 1.0 / modes[mass, present]
            q, rate, acceleration = (
                y[block + row : block + row + modes.shape[1]][present]
                for block in (lay.POSITION, lay.VELOCITY, lay.ACCELERATION)
            )
            kinetic += (m * rate * acceleration).sum()
            stored += (m * modes[core.STIFFNESS_PER_MASS, present] * q * rate).sum()
            dissipated += (m * modes[core.DAMPING_PER_MASS, present] * rate**2).sum()
            supplied += (modes[f, present] * rate).sum()
        s = model.support
        supplied -= s.F * v[lay.X] + s.F_across * v[lay.Y]
        stored += s.k_b * ((y[lay.X] - s.x_0) * v[lay.X] + (y[lay.Y] - s.y_0) * v[lay.Y])
        dissipated += s.c_b * (v[lay.X] ** 2 + v[lay.Y] ** 2)
        if isinstance(model.bending.springs, core.Springs):
            states = spring_states(scene)
            force = np.where(
                states["compression"] > 0.0,
                np.maximum(states["k"] * states["compression"] + states["c"] * states["rate"], 0.0),
                0.0,
            )
            stored += (force * states["rate"]).sum()  # and dissipated by its dampers
            partly_compressed += 0 < (states["compression"] > 0.0).sum() < len(force)
        lanes = slice(0, b.Z)
        r_v = y[lay.RADIAL_V : lay.RADIAL_V + b.Z]
        outer, inner = y[lay.Q_O : lay.Q_O + b.Z], y[lay.Q_I : lay.Q_I + b.Z]
        closing_o, closing_i = y[lay.V_O : lay.V_O + b.Z], y[lay.V_I : lay.V_I + b.Z]
        kinetic += b.m_r * (r_v * y[lay.RADIAL_A : lay.RADIAL_A + b.Z])[lanes].sum()
        r = 0.5 * (b.R_o + b.R_i) + y[lay.RADIAL : lay.RADIAL + b.Z]
        supplied += (b.m_r * b.omega_c**2 * r * r_v).sum()
        cage = (outer * race_radial_speed(scene)).sum()
        stored += (outer * closing_o + inner * closing_i).sum()  # and dissipated by the contacts' dampers
        scale = np.abs(outer * closing_o).sum() + abs(supplied) + abs(stored)
        assert kinetic + stored + dissipated == pytest.approx(supplied - cage, abs=1e-9 * scale)
    if load in (POINTS, HOUSING):
        assert partly_compressed > 0


@pytest.mark.parametrize("load", [None, UNEVEN])
def test_influence_coefficients_are_symmetric(load):
    """Symmetric to 1e-12 of the largest coefficient, between all roller positions.

    A force on the ring at one roller changes the approach of the race at another. Forces and approaches use two
    tables of the model, which must agree with each other and with its springs.
    """
    scene = random_scene(case(8, load, defect=None), 0, t=1.1e-3, spread=0.0)
    model, y, Z = scene.model, scene.y, scene.model.bearing.Z
    modes = model.bending.harmonic_table
    cells, per_mass = [lay.X, lay.Y], [1.0 / model.bearing.m_o] * 2
    for row, mass in ((lay.MODES_C, core.INVERSE_MASS_C), (lay.MODES_S, core.INVERSE_MASS_S)):
        for i in np.flatnonzero(modes[mass]).tolist():
            cells.append(row + i)
            per_mass.append(modes[mass, i])
    y[lay.VELOCITY : lay.VELOCITY + lay.STATE] = 0.0
    y[lay.POSITION + lay.FIRST_LANE : lay.POSITION + lay.FIRST_LANE + Z] = -1e-5

    def displaced(cell, displacement):
        """Return forces on the ring (N), approaches (m) and outer contact forces (N) of the rollers."""
        state = y.copy()
        state[lay.POSITION + cell] += displacement
        start_at_rest(model, scene.t, state)
        forces = state[[lay.ACCELERATION + c for c in cells]] / np.array(per_mass)
        return forces, state[lay.DELTA_O : lay.DELTA_O + Z], state[lay.Q_O : lay.Q_O + Z]

    base, _, outer_forces = displaced(lay.X, 0.0)
    assert not outer_forces.any()
    pairs = [(displaced(cell, 1e-7), displaced(cell, -1e-7)) for cell in cells]
    stiffness = np.array([(minus[0] - plus[0]) / 2e-7 for plus, minus in pairs]).T
    approach = np.array([(plus[1] - minus[1]) / 2e-7 for plus, minus in pairs]).T
    roller_states = [displaced(lay.FIRST_LANE + j, 2e-5) for j in range(Z)]
    contact_loads = np.array([(forces - base) / q[j] for j, (forces, _, q) in enumerate(roller_states)]).T
    influence = -approach @ np.linalg.solve(stiffness, contact_loads)
    assert np.abs(influence - influence.T).max() <= 1e-12 * np.abs(influence).max()


def race_radial_speed(scene: Scene) -> np.ndarray:
    """Return the radial speed (m/s) of the deformed race under each roller due to the cage's rotation."""
    y, b, ring = scene.y, scene.model.bearing, scene.model.bending
    theta = np.arctan2(y[lay.SIN : lay.SIN + b.Z], y[lay.COS : lay.COS + b.Z])
    slope = -y[lay.X] * np.sin(theta) + y[lay.Y] * np.cos(theta)
    for i in range(ring.breathing_index + 1):
        n = ring.harmonic_table[core.ORDER, i]
        slope += n * (y[lay.MODES_S + i] * np.cos(n * theta) - y[lay.MODES_C + i] * np.sin(n * theta))
    return b.omega_c * slope


def test_the_sensor_reads_the_sum_of_all_harmonics():
    """Displacement, velocity and acceleration at 25 deg equal a direct sum."""
    scene = random_scene(case(8, rig={"sensor": {"angle": "25 deg"}}), 1)
    read_sensor(scene.model, scene.y)
    alpha, b = 25.0 * pi / 180.0, scene.model.bending
    for block, cell in (
        (lay.POSITION, lay.SENSOR),
        (lay.VELOCITY, lay.SENSOR_V),
        (lay.ACCELERATION, lay.SENSOR_A),
    ):
        total = scene.y[block + lay.X] * np.cos(alpha) + scene.y[block + lay.Y] * np.sin(alpha)
        for i in range(b.breathing_index + 1):
            n = b.harmonic_table[core.ORDER, i]
            total += scene.y[block + lay.MODES_C + i] * np.cos(n * alpha)
            total += scene.y[block + lay.MODES_S + i] * np.sin(n * alpha)
        assert scene.y[cell] == pytest.approx(total, rel=1e-12)


@pytest.mark.parametrize(("bearing", "harmonics"), [("nf308", 20), ("nf308", 2), ("nu205", 2), ("nu205", 8)])
def test_the_step_limit_includes_the_coupling_of_rollers(bearing, harmonics):
    """Stiffness and damping over mass are at least the largest eigenvalues of a bearing with all rollers loaded.

    By finite differences of the accelerations; a clearance of -20 um loads every roller.
    """
    bearing_case = case(
        harmonics, bearing=bearing, clearance="-20 um", defect=None, rig={"bracket_damping": "0 N s/m"}
    )
    model = assemble.model(bearing_case)
    y = assemble.empty_buffer(model)
    solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
    K, C = start_at_rest(model, 0.0, y)
    b, modes = model.bearing, model.bending.harmonic_table
    cells = [lay.X, lay.Y, *range(lay.FIRST_LANE, lay.FIRST_LANE + b.Z)]
    for row, mass in ((lay.MODES_C, core.INVERSE_MASS_C), (lay.MODES_S, core.INVERSE_MASS_S)):
        cells += [row + i for i in range(modes.shape[1]) if modes[mass, i] > 0.0]
    for block, bound, step in ((lay.POSITION, K, 1e-10), (lay.VELOCITY, C, 1e-6)):
        columns = []
        for cell in cells:
            sides = []
            for displacement in (-step, step):
                state = y.copy()
                state[block + cell] += displacement
                start_at_rest(model, 0.0, state)
                sides.append(state[[lay.ACCELERATION + c for c in cells]])
            columns.append((sides[1] - sides[0]) / (2.0 * step))
        largest = np.abs(np.linalg.eigvals(np.array(columns))).max()
        assert largest <= bound <= 2.5 * largest


@pytest.mark.parametrize("turn", [0.0, 20.0, 45.0, 70.0])
def test_the_damping_of_springs_does_not_depend_on_their_direction(turn):
    """Of two opposite springs k, c = 2 zeta k sqrt(m/(2 k)): the rigid ring between them has the damping ratio
    zeta."""
    k, at = 1e8, [{"angle": f"{angle + turn} deg", "stiffness": "1e8 N/m"} for angle in (0.0, 180.0)]
    sideways = [{"angle": f"{angle + turn} deg", "stiffness": "1e6 N/m"} for angle in (90.0, 270.0)]
    scene = case(load={"by": "points", "at": at + sideways})
    table = bending.build_bending(bending.ring_parameters(scene)).springs.spring_table
    expected = 2.0 * 0.01 * k * np.sqrt(bending.ring_parameters(scene).ring_mass / (2.0 * k))
    assert table[core.SPRING_DAMPING, :2] == pytest.approx([expected, expected], rel=1e-9)
