"""The outer ring that bends: against independent solutions, by its power, and where it must be as a rigid one."""

import cmath
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
from bearingsim.core.models.interface import accelerations, read_sensor, state_width
from bearingsim.core.parameters import lanes
from bearingsim.core.parts import bending as core
from bearingsim.simulation import simulate
from tests.independent import beam_ring, bent_rollers, bent_static, ring_elements
from tests.independent import rollers as nf308
from tests.scenes.nf308 import SLOT

PADS = {"by": "pads", "angles": ["-45 deg", "45 deg"]}
HOUSING = {"by": "housing", "stiffness": "1e10 N/m/m"}
POINTS = {
    "by": "points",
    "at": [{"angle": "-45 deg", "stiffness": "1e8 N/m"}, {"angle": "45 deg", "stiffness": "1e8 N/m"}],
}
UNEVEN = {
    "by": "points",
    "at": [
        {"angle": f"{at} deg", "stiffness": k} for at, k in ((-50, "1e8 N/m"), (10, "3e8 N/m"), (35, "2e8 N/m"))
    ],
}
KRAEMER = {"damping": {"law": "kraemer", "beta": "2.5 us"}}


def case(harmonics=8, load=None, model="rollers", rig=None, **given) -> Case:
    """The NF308 at 1800 rpm and 150 N with a slot, its ring bending unless ``harmonics`` is 0."""
    ring = {"ring": {"harmonics": harmonics}, "load": load or {"by": "point"}} if harmonics else {}
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": model, "record": []}
    base |= {"contact": KRAEMER, "duration": "0.1 s", "rig": ring | (rig or {}), "defect": SLOT}
    found = {key: value for key, value in (base | given).items() if value is not None}
    return Case.model_validate(found)


def line(found: Case) -> complex:
    """The line at BPFO, um/s."""
    read = simulate(found).features
    return 1e6 * cmath.rect(read["velocity@BPFO"], read["velocity@BPFO.phase"])


def less_healthy(*given, **more) -> float:
    """The line of the slot less that of the healthy bearing, um/s."""
    return abs(line(case(*given, **more)) - line(case(*given, **more | {"defect": None})))


# The beam


@pytest.mark.parametrize("n", [0, 2, 3, 5, 8, 20])
def test_a_harmonic_is_that_of_the_independent_beam(n):
    """Of the NF308's ring."""
    of_case = bending.ring_section(bending.ring_parameters(case()))
    found = bending.harmonic(of_case, n)
    assert of_case.mass == pytest.approx(beam_ring.NF308.mass, rel=1e-12)
    assert found.k == pytest.approx(1.0 / beam_ring.compliance(n), rel=1e-9)
    assert found.omega == pytest.approx(2.0 * pi * beam_ring.frequencies(n)[0], rel=1e-9)


def test_the_beam_is_near_plane_stress_elements():
    """Frequencies n = 2 to 5 within 0.5 %, compliances n = 2 to 8 within 3 % (they stay under 0.3 and 2.2 %)."""
    section = bending.ring_section(bending.ring_parameters(case()))
    body = ring_elements.free_frequencies()  # two of each
    found = [bending.harmonic(section, n).omega / (2.0 * pi) for n in (2, 3, 4, 5)]
    assert found == pytest.approx(body[::2], rel=5e-3)
    stiff = [bending.harmonic(section, n).k for n in range(2, 9)]
    assert 1.0 / np.array(stiff) == pytest.approx(ring_elements.compliances(range(2, 9)), rel=3e-2)


# The right-hand side


@dataclass
class Scene:
    """A model and a state of it at random, near rest."""

    model: Any
    y: np.ndarray
    t: float


def at_random(found: Case, seed: int, t: float = 0.0, apart: float = 1e-7) -> Scene:
    """``found`` somewhere near its rest: places by ``apart`` (m), velocities by 1 mm/s."""
    model, draw = assemble.model(found), np.random.default_rng(seed)
    y = assemble.empty_buffer(model)
    solve_initial_equilibrium(assemble.static_model(model), t, y)
    Z, H = model.bearing.Z, model.bending.harmonic_table.shape[1]
    cells = [lay.X, lay.Y, *range(lay.FIRST_LANE, lay.FIRST_LANE + Z)]
    for row, mass in ((lay.MODES_C, core.PER_MASS_C), (lay.MODES_S, core.PER_MASS_S)):
        cells += [row + i for i in range(H) if model.bending.harmonic_table[mass, i] > 0.0]
    y[[lay.POSITION + c for c in cells]] += apart * draw.normal(size=len(cells))
    y[[lay.VELOCITY + c for c in cells]] = 1e-3 * draw.normal(size=len(cells))
    accelerations(model, t, y)
    return Scene(model, y, t)


def in_their_order(found: Scene, block: int) -> np.ndarray:
    """A block of the state as the independent solution has it: x, y, a_0, a_2, b_2, ..., then the rollers."""
    y, b = found.y[block:], found.model.bending
    modes = [y[lay.MODES_C + b.breathing_index]]
    for i in range(b.breathing_index):
        modes += [y[lay.MODES_C + i], y[lay.MODES_S + i]]
    return np.r_[y[lay.X], y[lay.Y], modes, y[lay.FIRST_LANE : lay.FIRST_LANE + found.model.bearing.Z]]


@pytest.mark.parametrize("harmonics", [5, 8, 20])
@pytest.mark.parametrize(("load", "outside"), [(None, bent_static.POINT), (PADS, bent_static.thrust(-45, 45))])
def test_accelerations_are_those_of_the_independent_solution(harmonics, load, outside):
    """Rollers outside the slot and in it: to 1e-9 of the largest of their kind. Without a bracket's spring, whose
    anchor theirs finds with rollers that are thrown outwards from the pitch circle.
    """
    scene = bent_static.Scene(last=harmonics, outside=outside, bracket=0.0)
    theirs = bent_rollers.equations(scene, bent_rollers.Motion(cap=bending.MAX_FREQUENCY / (2.0 * pi)))
    pass_time = 2.0 * pi / (nf308.Z * nf308.OMEGA_C)
    for seed, t in enumerate((0.0, 0.499 * pass_time, 0.51 * pass_time, 3.2e-3)):
        found = at_random(case(harmonics, load, rig={"bracket_stiffness": "0 N/m"}), seed, t)
        q, v, a = (in_their_order(found, block) for block in (lay.POSITION, lay.VELOCITY, lay.ACCELERATION))
        right = theirs.slope(t, np.r_[q, v])[len(q) :]
        for part in (slice(0, 2), slice(2, -nf308.Z), slice(-nf308.Z, None)):
            assert a[part] == pytest.approx(right[part], abs=1e-9 * np.abs(right[part]).max())


def of_springs(found: Scene) -> dict[str, np.ndarray]:
    """How far each spring is pressed (m), how fast, its stiffness and damping: by a direct sum over harmonics."""
    y, b = found.y, found.model.bending
    cosines, sines, k, c, fit = b.springs.spring_table[:, : b.springs.transposed_shapes.shape[1]]
    angles = np.arctan2(sines, cosines)
    values = []
    for block in (lay.POSITION, lay.VELOCITY):
        total = y[block + lay.X] * cosines + y[block + lay.Y] * sines
        for i in range(b.breathing_index + 1):
            n = b.harmonic_table[core.N, i]
            total += y[block + lay.MODES_C + i] * np.cos(n * angles) + y[block + lay.MODES_S + i] * np.sin(
                n * angles
            )
        carrier = b.springs.carrier
        values.append(
            total - y[block + lay.MODES_C + carrier] * cosines - y[block + lay.MODES_S + carrier] * sines
        )
    return {"pressed": values[0] + fit, "rate": values[1], "k": k, "c": c}


@pytest.mark.parametrize(
    "load", [None, PADS, POINTS, HOUSING, HOUSING | {"fit": "2 um"}, HOUSING | {"fit": "-2 um"}]
)
def test_power_balance(load):
    """What all masses gain, springs store and dampers take is what load, cage and centrifugal force give: to 1e-9.

    At random states with springs on either side of touching; the given forces' power counts with what they do.
    """
    pressed_both_ways = 0
    for seed in range(6):
        found = at_random(case(8, load, defect=None), seed, apart=1e-6)
        y, model = found.y, found.model
        b, modes = model.bearing, model.bending.harmonic_table
        v = {cell: y[lay.VELOCITY + cell] for cell in (lay.X, lay.Y)}
        gained = b.m_o * sum(v[cell] * y[lay.ACCELERATION + cell] for cell in v)
        stored = given = taken = 0.0
        for row, mass, f in (
            (lay.MODES_C, core.PER_MASS_C, core.LOAD_C),
            (lay.MODES_S, core.PER_MASS_S, core.LOAD_S),
        ):
            real = modes[mass] > 0.0
            m = 1.0 / modes[mass, real]
            q, rate, push = (
                y[block + row : block + row + modes.shape[1]][real]
                for block in (lay.POSITION, lay.VELOCITY, lay.ACCELERATION)
            )
            gained += (m * rate * push).sum()
            stored += (m * modes[core.K_M, real] * q * rate).sum()
            taken += (m * modes[core.C_M, real] * rate**2).sum()
            given += (modes[f, real] * rate).sum()
        s = model.support
        given -= s.F * v[lay.X] + s.F_across * v[lay.Y]
        stored += s.k_b * ((y[lay.X] - s.x_0) * v[lay.X] + (y[lay.Y] - s.y_0) * v[lay.Y])
        taken += s.c_b * (v[lay.X] ** 2 + v[lay.Y] ** 2)
        if isinstance(model.bending.springs, core.Springs):
            of = of_springs(found)
            force = np.where(
                of["pressed"] > 0.0, np.maximum(of["k"] * of["pressed"] + of["c"] * of["rate"], 0.0), 0.0
            )
            stored += (force * of["rate"]).sum()  # with what its dampers take
            pressed_both_ways += 0 < (of["pressed"] > 0.0).sum() < len(force)
        lanes = slice(0, b.Z)
        r_v = y[lay.RADIAL_V : lay.RADIAL_V + b.Z]
        outer, inner = y[lay.Q_O : lay.Q_O + b.Z], y[lay.Q_I : lay.Q_I + b.Z]
        closing_o, closing_i = y[lay.V_O : lay.V_O + b.Z], y[lay.V_I : lay.V_I + b.Z]
        gained += b.m_r * (r_v * y[lay.RADIAL_A : lay.RADIAL_A + b.Z])[lanes].sum()
        r = 0.5 * (b.R_o + b.R_i) + y[lay.RADIAL : lay.RADIAL + b.Z]
        given += (b.m_r * b.omega_c**2 * r * r_v).sum()
        cage = (outer * climbed(found)).sum()
        stored += (outer * closing_o + inner * closing_i).sum()  # with what the contacts' dampers take
        scale = np.abs(outer * closing_o).sum() + abs(given) + abs(stored)
        assert gained + stored + taken == pytest.approx(given - cage, abs=1e-9 * scale)
    if load in (POINTS, HOUSING | {"fit": "0 um"}):
        assert pressed_both_ways > 0


@pytest.mark.parametrize("load", [None, UNEVEN])
def test_what_a_force_moves_elsewhere_a_force_there_moves_here(load):
    """Between all places of rollers, to 1e-12 of the largest. Forces enter as a roller presses, and what moves is
    how far rollers come near the race, so that two tables of the model and its springs must agree.
    """
    found = at_random(case(8, load, defect=None), 0, t=1.1e-3, apart=0.0)
    model, y, Z = found.model, found.y, found.model.bearing.Z
    modes = model.bending.harmonic_table
    cells, per_mass = [lay.X, lay.Y], [1.0 / model.bearing.m_o] * 2
    for row, mass in ((lay.MODES_C, core.PER_MASS_C), (lay.MODES_S, core.PER_MASS_S)):
        for i in np.flatnonzero(modes[mass]).tolist():
            cells.append(row + i)
            per_mass.append(modes[mass, i])
    y[lay.VELOCITY : lay.VELOCITY + lay.STATE] = 0.0
    y[lay.POSITION + lay.FIRST_LANE : lay.POSITION + lay.FIRST_LANE + Z] = -1e-5

    def moved(cell, by):
        """Forces on the ring (N), approaches (m) and outer forces (N) of rollers."""
        there = y.copy()
        there[lay.POSITION + cell] += by
        accelerations(model, found.t, there)
        forces = there[[lay.ACCELERATION + c for c in cells]] / np.array(per_mass)
        return forces, there[lay.DELTA_O : lay.DELTA_O + Z], there[lay.Q_O : lay.Q_O + Z]

    still, _, pressed = moved(lay.X, 0.0)
    assert not pressed.any()
    far = [(moved(cell, 1e-7), moved(cell, -1e-7)) for cell in cells]
    stiffness = np.array([(back[0] - forth[0]) / 2e-7 for forth, back in far]).T
    nearer = np.array([(forth[1] - back[1]) / 2e-7 for forth, back in far]).T
    by_rollers = [moved(lay.FIRST_LANE + j, 2e-5) for j in range(Z)]
    pushes = np.array([(forces - still) / q[j] for j, (forces, _, q) in enumerate(by_rollers)]).T
    moves = -nearer @ np.linalg.solve(stiffness, pushes)
    assert np.abs(moves - moves.T).max() <= 1e-12 * np.abs(moves).max()


def climbed(found: Scene) -> np.ndarray:
    """How fast each roller would climb the ring as it stands, by the cage's turning alone (m/s): a direct sum."""
    y, b, bent = found.y, found.model.bearing, found.model.bending
    theta = np.arctan2(y[lay.SIN : lay.SIN + b.Z], y[lay.COS : lay.COS + b.Z])
    slope = -y[lay.X] * np.sin(theta) + y[lay.Y] * np.cos(theta)
    for i in range(bent.breathing_index + 1):
        n = bent.harmonic_table[core.N, i]
        slope += n * (y[lay.MODES_S + i] * np.cos(n * theta) - y[lay.MODES_C + i] * np.sin(n * theta))
    return b.omega_c * slope


def test_the_sensor_reads_the_sum_of_all_harmonics():
    """At 25 deg: by a direct sum."""
    found = at_random(case(8, rig={"sensor": {"angle": "25 deg"}}), 1)
    read_sensor(found.model, found.y)
    alpha, b = 25.0 * pi / 180.0, found.model.bending
    for block, cell in (
        (lay.POSITION, lay.SENSOR),
        (lay.VELOCITY, lay.SENSOR_V),
        (lay.ACCELERATION, lay.SENSOR_A),
    ):
        total = found.y[block + lay.X] * np.cos(alpha) + found.y[block + lay.Y] * np.sin(alpha)
        for i in range(b.breathing_index + 1):
            n = b.harmonic_table[core.N, i]
            total += found.y[block + lay.MODES_C + i] * np.cos(n * alpha)
            total += found.y[block + lay.MODES_S + i] * np.sin(n * alpha)
        assert found.y[cell] == pytest.approx(total, rel=1e-12)


@pytest.mark.parametrize(("bearing", "harmonics"), [("nf308", 20), ("nf308", 2), ("nu205", 2), ("nu205", 8)])
def test_the_step_limit_counts_what_rollers_do_together(bearing, harmonics):
    """Stiffness and damping over mass are at least the largest eigenvalues of a bearing whose rollers all carry.

    By finite differences of the accelerations; -20 um of clearance press every roller.
    """
    found = case(harmonics, bearing=bearing, clearance="-20 um", defect=None, rig={"bracket_damping": "0 N s/m"})
    model = assemble.model(found)
    y = assemble.empty_buffer(model)
    solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
    K, C = start_at_rest(model, 0.0, y)
    b, modes = model.bearing, model.bending.harmonic_table
    cells = [lay.X, lay.Y, *range(lay.FIRST_LANE, lay.FIRST_LANE + b.Z)]
    for row, mass in ((lay.MODES_C, core.PER_MASS_C), (lay.MODES_S, core.PER_MASS_S)):
        cells += [row + i for i in range(modes.shape[1]) if modes[mass, i] > 0.0]
    for block, most, step in ((lay.POSITION, K, 1e-10), (lay.VELOCITY, C, 1e-6)):
        columns = []
        for cell in cells:
            sides = []
            for way in (-step, step):
                there = y.copy()
                there[block + cell] += way
                accelerations(model, 0.0, there)
                sides.append(there[[lay.ACCELERATION + c for c in cells]])
            columns.append((sides[1] - sides[0]) / (2.0 * step))
        largest = np.abs(np.linalg.eigvals(np.array(columns))).max()
        assert largest <= most <= 2.5 * largest


# At rest


@pytest.mark.parametrize(
    ("load", "outside", "wanted"),
    [
        (None, bent_static.POINT, 93.58),
        (PADS, bent_static.thrust(-45, 45), 4.585),
        ({"by": "pads", "angles": ["-60 deg", "0 deg", "60 deg"]}, bent_static.thrust(-60, 0, 60), 40.88),
    ],
)
def test_static_lines_are_those_of_the_independent_solution(load, outside, wanted):
    """Harmonics to 30, less healthy, um/s: within 1 %."""
    assert less_healthy(30, load, model="static", contact=None) == pytest.approx(wanted, rel=1e-2)


@pytest.mark.parametrize("load", [None, PADS, HOUSING])
def test_the_path_at_rest_is_that_of_the_independent_solution(load):
    """Displacement of ring and sensor at five cage angles, to 1e-6 of their range."""
    outside = {None: bent_static.POINT, str(PADS): bent_static.thrust(-45, 45)}.get(
        load and str(load), bent_static.seat(1e10, pieces=64)
    )
    model = assemble.static_model(assemble.model(case(8, load, model="static", contact=None)))
    scene = bent_static.Scene(last=8, outside=outside)
    turned = pi / nf308.Z + bent_static.PASS * np.array([0.0, 0.2, 0.49, 0.53, 0.8])
    theirs = bent_static.over(scene, turned, bent_static.anchored(scene))
    y, found = assemble.empty_buffer(model), []
    for angle in turned:
        left = solve_initial_equilibrium(model, (angle - model.bearing.theta_0) / model.bearing.omega_c, y)
        assert left <= 1e-8 * 150.0
        core.read_sensor(model.bending, y)
        found.append(y[lay.SENSOR])
    assert found == pytest.approx(list(theirs.reading), abs=1e-6 * np.ptp(theirs.reading))


def test_two_springs_push_as_two_pads():
    """Whatever their stiffness: with the bracket at 0 each has the same share of the load (1e-6)."""
    free = {"bracket_stiffness": "0 N/m", "bracket_damping": "0 N s/m"}
    found = [simulate(case(8, load, model="static", rig=free, contact=None)).features for load in (PADS, POINTS)]
    for name in ("velocity@BPFO", "velocity.rms", "outer_force.max"):
        assert found[0][name] == pytest.approx(found[1][name], rel=1e-6)


@pytest.mark.parametrize("load", [None, PADS])
def test_a_ring_that_is_ten_thousand_times_as_stiff_is_rigid(load):
    """Line and RMS of `static`: to 2e-3, ten times as stiff to 2e-4."""
    rigid = simulate(case(0, model="static", contact=None)).features
    for modulus, close in ((207e13, 2e-3), (207e14, 2e-4)):
        material = case().bearing.material.model_copy(update={"young_modulus": modulus})
        bearing = case().bearing.model_copy(update={"material": material})
        bent = simulate(case(8, load, model="static", bearing=bearing, contact=None)).features
        for name in ("velocity@BPFO", "velocity.rms"):
            assert bent[name] == pytest.approx(rigid[name], rel=close)


# In motion


@pytest.mark.slow
def test_lines_under_a_point_load_are_those_of_the_independent_solution():
    """Harmonics to 8: 94.05 and 11.70 um/s there (tests/independent/test_bent_rollers.py), within 1 %."""
    assert less_healthy(8) == pytest.approx(94.05, rel=1e-2)
    assert abs(line(case(8, defect=None))) == pytest.approx(11.70, rel=1e-2)


@pytest.mark.slow
def test_slow_rollers_are_at_rest():
    """At a hundredth of the speed the displacement's line is that of `static` within 1 %."""
    slow = {"speed": "18 rpm", "duration": "1.3 s", "settle": "0.7 s", "sampling": "1 kHz"}
    found = [simulate(case(8, model=model, contact=None, **slow)).features for model in ("static", "rollers")]
    assert found[1]["displacement@BPFO"] == pytest.approx(found[0]["displacement@BPFO"], rel=1e-2)


def test_all_methods_agree_on_a_bent_ring():
    """Verlet, Runge-Kutta and an adaptive one, on the same 20 ms: line and RMS within 0.5 %."""
    base = {"defect": None, "duration": "20 ms", "settle": "5 ms", "step_check": False, "periodic": False}
    found = {method: simulate(case(8, method=method, **base)).features for method in ("verlet", "rk4", "dop853")}
    for name in ("velocity@BPFO", "velocity.rms"):
        for method, features in found.items():
            assert features[name] == pytest.approx(found["dop853"][name], rel=5e-3), method


def test_half_the_step_changes_what_is_said():
    """The automatic step is right for a bent ring on springs: halved, Verlet's line moves within its bound."""
    found = case(8, HOUSING | {"stiffness": "1e11 N/m/m"}, defect=None, method="verlet")
    told = simulate(found)
    step = 0.5 * float(told.info["step_s"])
    finer = simulate(found.model_copy(update={"step": step, "step_check": False}))
    change = abs(finer.features["velocity.rms"] / told.features["velocity.rms"] - 1.0)
    assert change <= told.features["step_error.rms"]


def test_doubling_the_springs_of_a_housing_changes_little(monkeypatch):
    """Line and RMS at rest by less than 0.5 %, with a gap too (that number is halved: no more fit the buffer)."""
    for fit, name, other in (("0 um", "SPRINGS", 160), ("-15 um", "SPRINGS_WITH_A_GAP", 160)):
        stiff = {"fit": fit, "stiffness": "1e10 N/m/m"}
        found = case(20, HOUSING | stiff, model="static", contact=None)
        once = simulate(found).features
        monkeypatch.setattr(bending, name, other)
        bending.build_bending.cache_clear()
        assemble._build_model.cache_clear()
        twice = simulate(found).features
        monkeypatch.undo()
        bending.build_bending.cache_clear()
        assemble._build_model.cache_clear()
        for feature in ("velocity@BPFO", "velocity.rms"):
            assert twice[feature] == pytest.approx(once[feature], rel=5e-3)


def test_a_rigid_ring_knows_nothing_of_it():
    """Its model has no harmonics, and its state is as wide as before."""
    model = assemble.model(case(0))
    assert isinstance(model.bending, core.RigidRing)
    assert core.harmonics(model.bending) == 0
    assert state_width(model) == lay.FIRST_LANE + lanes(model.bearing)
