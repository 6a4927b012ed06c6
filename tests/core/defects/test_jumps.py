"""Positions of force jumps, and times at which contacts reach them."""

from math import inf

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.defects.jumps import next_jump
from bearingsim.core.defects.on_roller import roller_at_defect
from bearingsim.core.defects.pairs import FIRST_JUMP, HALF_WIDTH, JUMP_COUNT
from bearingsim.core.jit import jit
from bearingsim.core.methods.dormand_prince import DormandPrince
from bearingsim.core.methods.interface import prepare
from bearingsim.core.models.interface import accelerations
from tests.scenes.nf308 import SLOT, at_rest, case

WIDE = SLOT | {"width": "3 mm"}


@jit
def prepared(method, model, t, y):
    """Prepare a method at time ``t``."""
    prepare(method, model, t, y)


def jump_positions(**options):
    """Return the positions (mm) of jumps of the first roller-defect pair."""
    head = assemble.defects.pack_case_defects(case(**options)).head[0]
    return 1e3 * head[FIRST_JUMP : FIRST_JUMP + int(head[JUMP_COUNT])]


def test_jumps_of_narrow_and_wide_slots():
    """The roller (relative radius R) reaches the floor sqrt(2 R d) behind the rim."""
    assert jump_positions(defect=SLOT) == pytest.approx([0.0], abs=1e-9)
    R = assemble.defects.reduced_radius(case(), 0)
    floor_edge = 1.5 - 1e3 * np.sqrt(2.0 * R * 0.05e-3)
    assert jump_positions(defect=WIDE) == pytest.approx([-floor_edge, floor_edge], abs=1e-6)


def test_jumps_at_rims_of_envelopes_and_pulses():
    """A parabola starts with zero slope, a rectangle and a sine do not; a smooth bowl has no jump."""
    assert jump_positions(defect=SLOT, excitation="rectangular-pulse") == pytest.approx([-0.4, 0.4])
    assert jump_positions(defect=SLOT, excitation="half-sine-pulse") == pytest.approx([-0.4, 0.4])
    assert len(jump_positions(defect=WIDE | {"shape": "circular", "length": "9 mm", "depth": "5 um"})) == 0


def test_a_traced_defect_has_the_cusps_of_its_path():
    """A narrow ellipse has one cusp; of a rough spall at most the 32 sharpest are stored."""
    assert jump_positions(defect=SLOT | {"shape": "elliptical", "length": "9 mm"}) == pytest.approx(
        [0.0], abs=1e-6
    )
    rough = jump_positions(defect=SLOT | {"shape": "spall", "width": "2 mm", "grown": 0.5})
    assert 1 < len(rough) <= 32
    assert (np.diff(rough) > 0).all()


@jit
def compiled_next_jump(model, t, y):
    """Return ``next_jump`` in compiled code."""
    return next_jump(model, t, y)


@jit
def jump_and_roller(model, t, y):
    """Return ``next_jump``, and roller and position at the first roller-defect pair."""
    accelerations(model, t, y)
    return next_jump(model, t, y), roller_at_defect(model, 0, t, y)


@pytest.mark.parametrize("race", ["outer", "inner", "roller"])
def test_next_jump_with_a_kinematic_cage_is_exact(race):
    """A contact is at the jump at the predicted time; each jump is predicted once."""
    model = assemble.model(case(defect=WIDE | {"race": race}))
    y, t, positions = at_rest(model), 0.0, model.defects.head[0, FIRST_JUMP:]
    distances = []
    for _ in range(12):
        t_jump, _ = jump_and_roller(model, t, y)
        assert t < t_jump < t + 0.02
        _, (_, s) = jump_and_roller(model, t_jump, y)
        distances.append(np.abs(s - positions).min() if race != "roller" else 0.0)
        t = t_jump + 1e-12
    assert max(distances) < 1e-11


def test_the_stored_next_jump_is_valid_until_it_is_passed():
    """A method that begins again at an earlier time discards it."""
    model = assemble.model(case(defect=WIDE))
    y = at_rest(model)
    first = compiled_next_jump(model, 0.0, y)
    y[lay.NEXT_STOP] = first
    assert compiled_next_jump(model, 0.5 * first, y) == first
    second = compiled_next_jump(model, first + 1e-9, y)
    assert second > first
    y[lay.NEXT_STOP] = second
    prepared(DormandPrince(1e-6, 1e-4, 1e-12, 1e-9, 1e-4), model, 0.0, y)
    assert y[lay.NEXT_STOP] == first


def test_no_jump_without_defects():
    """The time of the next jump is infinite."""
    model = assemble.model(case())
    assert compiled_next_jump(model, 0.0, at_rest(model)) == inf


def test_predicted_jump_of_a_free_roller_converges():
    """In `planar` each prediction is short of the jump by a hundredth of the distance, until it is reached."""
    model = assemble.model(case(model="planar", defect=SLOT))
    y = at_rest(model)
    t, distances = 0.0, []
    for _ in range(600):
        t_jump, (_, s) = jump_and_roller(model, t, y)
        if abs(s) < model.defects.head[0, HALF_WIDTH] and s < 0.0:
            distances.append(-s)
            t = t_jump
        else:
            t += 2e-5
        if distances and distances[-1] < 1e-10:
            break
    ratios = np.array(distances[1:]) / distances[:-1]
    assert distances[-1] < 1e-10
    assert (ratios < 0.02).all()
