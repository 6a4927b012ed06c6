"""Where forces jump, and when contacts come there."""

from math import inf

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core.defects.jumps import next_jump
from bearingsim.core.defects.on_roller import roller_at_defect
from bearingsim.core.defects.pairs import FIRST_JUMP, HALF_WIDTH, JUMP_COUNT
from bearingsim.core.jit import jit
from bearingsim.core.models.interface import accelerations
from tests.scenes.nf308 import SLOT, at_rest, case

WIDE = SLOT | {"width": "3 mm"}


def jumps(**given):
    """Places (mm) of the first meeting's jumps."""
    head = assemble.defects.packed_defects(case(**given)).head[0]
    return 1e3 * head[FIRST_JUMP : FIRST_JUMP + int(head[JUMP_COUNT])]


def test_a_narrow_slot_has_one_cusp_and_a_wide_one_where_the_floor_begins_and_ends():
    """The roller (relative radius R) reaches the floor sqrt(2 R d) behind the rim."""
    assert jumps(defect=SLOT) == pytest.approx([0.0], abs=1e-9)
    R = assemble.defects.reduced_radius(case(), 0)
    reached = 1.5 - 1e3 * np.sqrt(2.0 * R * 0.05e-3)
    assert jumps(defect=WIDE) == pytest.approx([-reached, reached], abs=1e-6)


def test_rims_of_an_envelope_are_smooth_and_those_of_a_pulse_are_not():
    """A parabola starts level; a rectangle and a sine do not; a smooth bowl that is touched has no jump at all."""
    assert jumps(defect=SLOT, excitation="rectangular-pulse") == pytest.approx([-0.4, 0.4])
    assert jumps(defect=SLOT, excitation="half-sine-pulse") == pytest.approx([-0.4, 0.4])
    assert len(jumps(defect=WIDE | {"shape": "circular", "length": "9 mm", "depth": "5 um"})) == 0


def test_a_traced_defect_has_the_cusps_of_its_path():
    """An ellipse as narrow as a slot, and a rough spall: the sharpest, no more than there is room for."""
    assert jumps(defect=SLOT | {"shape": "elliptical", "length": "9 mm"}) == pytest.approx([0.0], abs=1e-6)
    rough = jumps(defect=SLOT | {"shape": "spall", "width": "2 mm", "grown": 0.5})
    assert 1 < len(rough) <= 32
    assert (np.diff(rough) > 0).all()


@jit
def asked(model, t, y):
    """``next_jump``, compiled."""
    return next_jump(model, t, y)


@jit
def told(model, t, y):
    """What ``next_jump`` says, and where the first meeting's contact stands."""
    accelerations(model, t, y)
    return next_jump(model, t, y), roller_at_defect(model, 0, t, y)


@pytest.mark.parametrize("race", ["outer", "inner", "roller"])
def test_with_a_kinematic_cage_the_next_jump_is_known(race):
    """At the time told a contact stands on the jump; times follow each other, each jump once."""
    model = assemble.model(case(defect=WIDE | {"race": race}))
    y, t, places = at_rest(model), 0.0, model.defects.head[0, FIRST_JUMP:]
    seen = []
    for _ in range(12):
        at, _ = told(model, t, y)
        assert t < at < t + 0.02
        _, (_, s) = told(model, at, y)
        seen.append(np.abs(s - places).min() if race != "roller" else 0.0)
        t = at + 1e-12
    assert max(seen) < 1e-11


def test_without_defects_nothing_jumps():
    """And the next jump is never."""
    model = assemble.model(case())
    assert asked(model, 0.0, at_rest(model)) == inf


def test_a_free_roller_is_closed_in_upon():
    """In `planar` each time told falls short of the jump, by a hundredth of the way, until it is met."""
    model = assemble.model(case(model="planar", defect=SLOT))
    y = at_rest(model)
    t, way = 0.0, []
    for _ in range(600):
        at, (_, s) = told(model, t, y)
        if abs(s) < model.defects.head[0, HALF_WIDTH] and s < 0.0:
            way.append(-s)
            t = at
        else:
            t += 2e-5
        if way and way[-1] < 1e-10:
            break
    ratios = np.array(way[1:]) / way[:-1]
    assert way[-1] < 1e-10
    assert (ratios < 0.02).all()
