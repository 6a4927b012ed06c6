"""Parameters of the model `impulse`."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.assemble import contacts
from bearingsim.config import Case
from bearingsim.simulation.limits import load_and_rates_at_rest

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
BASE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "impulse", "defect": SLOT}


def impulse(**fields: object) -> Case:
    return Case.model_validate(BASE | fields)


def test_the_ring_is_damped_by_its_contacts() -> None:
    """The mean damping is below the largest of `ring` at rest over a ball pass."""
    case = impulse()
    impulse_model, ring = assemble.model(case), case.model_copy(update={"model": "ring", "method": "verlet"})
    _, _, largest = load_and_rates_at_rest(ring)
    contact_damping = impulse_model.C_x - case.rig.bracket_damping
    assert 0.3 * largest < contact_damping / impulse_model.m < largest


def test_damping_is_proportional_to_the_damping_time() -> None:
    once, twice = (assemble.model(impulse(contact={"damping": {"beta": beta}})) for beta in ("2 us", "4 us"))
    bracket = impulse().rig.bracket_damping
    assert twice.C_x - bracket == pytest.approx(2.0 * (once.C_x - bracket))
    assert twice.C_y - bracket == pytest.approx(2.0 * (once.C_y - bracket))


# Balls


def positions_at_rest(
    case: Case, defect: bool, k_b: float, anchor: np.ndarray, fractions: np.ndarray
) -> np.ndarray:
    """Return the ring's position (2, n) m at fractions of a ball pass, on Hertzian contacts and a bracket."""
    b, d, R_w = case.bearing, case.defects[0], case.bearing.roller_diameter / 2.0
    k_o, k_i = (contacts.build_stiffness_law(case, on_outer).k for on_outer in (True, False))
    k = (k_o ** (-2 / 3) + k_i ** (-2 / 3)) ** -1.5
    R_o = (b.pitch_diameter + b.roller_diameter) / 2.0
    theta = 2.0 * np.pi * (fractions[:, None] + np.arange(b.rollers)) / b.rollers
    s = (np.remainder(theta - d.angle + np.pi, 2.0 * np.pi) - np.pi) * R_o
    rim = np.maximum(d.width / 2.0 - np.abs(s), 0.0)
    h = np.minimum(rim**2 / 2.0 * (1.0 / R_w - 1.0 / R_o), d.depth) * defect
    e = np.stack([np.cos(theta), np.sin(theta)])
    u = np.tile(np.array([[-5e-6], [0.0]]), len(fractions))
    for _ in range(40):
        delta = np.maximum(-np.einsum("anj,an->nj", e, u) - h, 0.0)
        force = np.einsum("anj,nj->an", e, k * delta**1.5) - k_b * (u - anchor) - np.array([[case.load], [0.0]])
        slope = np.einsum("anj,bnj,nj->nab", e, e, 1.5 * k * np.sqrt(delta)) + k_b * np.eye(2)
        u += np.linalg.solve(slope, force.T[:, :, None])[:, :, 0].T
    assert np.abs(force).max() < 1e-8 * case.load
    return u


def amplitude_at_rest(case: Case) -> np.ndarray:
    """Return the displacement amplitude (2,) m at BPFO of a slow bearing, from the difference to a healthy one."""
    fractions, k_b = (np.arange(2000) + 0.5) / 2000, case.rig.bracket_stiffness
    anchor = positions_at_rest(case, False, 0.0, np.zeros((2, 1)), fractions).mean(axis=1, keepdims=True)
    damaged, healthy = (positions_at_rest(case, defect, k_b, anchor, fractions) for defect in (True, False))
    return np.abs(2.0 * np.mean((damaged - healthy) * np.exp(-2j * np.pi * fractions), axis=1))


@pytest.mark.parametrize("angle", [0.0, 0.5])
@pytest.mark.parametrize(("bearing", "width"), [("6205", 0.3e-3), ("6205", 0.8e-3), ("6309", 0.8e-3)])
def test_amplitude_of_balls_equals_quasi_static_solution(bearing: str, width: float, angle: float) -> None:
    """Amplitudes agree within 8 % along the load; across it, within 10 % of that along the load."""
    defect = SLOT | {"length": "7 mm", "width": width, "angle": angle}
    case = impulse(bearing=bearing, load="500 N", speed="60 rpm", duration="2 s", defect=defect)
    model, omega = assemble.model(case), 2.0 * np.pi * case.bearing.ball_pass_frequency(case.speed)
    amplitudes = [
        omega / np.pi * abs(J[0] / (K - model.m * omega**2 + 1j * omega * C))
        for J, K, C in ((model.J_x, model.K_x, model.C_x), (model.J_y, model.K_y, model.C_y))
    ]
    expected = amplitude_at_rest(case)
    assert amplitudes[0] == pytest.approx(expected[0], rel=0.08)
    assert amplitudes[1] == pytest.approx(expected[1], abs=0.1 * expected[0])
