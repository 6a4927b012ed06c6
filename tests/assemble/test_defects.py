"""From a case's defects to what its contacts meet: off the middle, merged, traced, in slices."""

from math import pi

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.assemble.defects import packed_defects, roller_defect_pairs
from bearingsim.core.defects.closed_forms import groups_of, roller_drop
from bearingsim.core.defects.depth import Circular, Rectangular, Triangular
from bearingsim.core.defects.excitations import Envelope, TracedPath, defect_response
from bearingsim.core.defects.on_roller import force_over_defect, mean_roller_drop
from bearingsim.core.defects.pairs import (
    ANGLE,
    CUSP,
    GROUP_COUNT,
    GROUP_HALF_WIDTH,
    GROUP_WEIGHT,
    HALF_WIDTH,
    REDUCED_RADIUS,
    SPAN,
    passing_speed,
)
from bearingsim.core.defects.traced import cut_along_roller, group_paths, pack_traced_defects
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.stiffness.power_laws import palmgren
from bearingsim.core.methods.verlet import Verlet
from bearingsim.errors import Refused
from bearingsim.simulation.simulate import SimulationError, simulate
from tests.scenes.nf308 import SLOT, at_rest, case, drive

SHORT = SLOT | {"length": "3 mm"}
BOWL = SHORT | {"shape": "circular"}
R_O = 0.0385


def sunk(defects, s, d=0):
    """Mean sinking (m) of a roller at ``s`` (m) from the middle of one meeting."""
    return mean_roller_drop(defects, d, s)


@pytest.mark.parametrize("shape", ["rectangular", "triangular", "circular"])
def test_a_defect_off_the_middle_is_felt_as_in_the_middle_while_it_is_on_the_roller(shape):
    centred, off = (
        packed_defects(case(defect=SHORT | {"shape": shape, "offset": at})) for at in ("0 mm", "-4.5 mm")
    )
    s = np.linspace(-5e-4, 5e-4, 41)
    assert [sunk(off, x) for x in s] == pytest.approx([sunk(centred, x) for x in s], rel=1e-12, abs=1e-18)
    assert isinstance(off.excitation, Envelope)


@pytest.mark.parametrize("offset", ["5.5 mm", "-5.5 mm"])
def test_what_hangs_over_the_rollers_end_is_not_felt(offset):
    """Of 3 mm with their middle 0.5 mm from the end 2 mm are on the roller."""
    found = packed_defects(case(defect=SHORT | {"offset": offset}))
    row = np.array([1.0, 4e-4, 1.0, 0.0, 5e-5])
    assert sunk(found, 1e-4) == pytest.approx(
        2 / 12 * roller_drop(row, 1e-4, found.head[0, REDUCED_RADIUS])[0], rel=1e-12
    )


@pytest.mark.parametrize("offset", [0.0, 4.9e-3, -5.5e-3, 6.5e-3])
def test_a_bowls_weights_are_its_overlap_with_the_roller(offset):
    """Against 20000 slices of even length."""
    R, length, width, depth, L_w = 7.1e-3, 3e-3, 8e-4, 5e-5, 12e-3
    rows = groups_of(Circular(length, width, depth), L_w, R, 24, offset)
    assert sum(row[GROUP_WEIGHT] for row in rows) == pytest.approx(1.0, rel=1e-12)
    z = (np.arange(20000) + 0.5) / 20000 * L_w - L_w / 2
    zeta = 2 * (z - offset) / length
    b = width / 2 * np.sqrt(np.maximum(1 - zeta**2, 0.0))
    for s in (0.0, 1.5e-4):
        mean = np.mean(np.maximum(b - s, 0.0) ** 2 / (2 * R))  # narrow: on its rims
        found = sum(row[GROUP_WEIGHT] * roller_drop(np.array(row), s, R)[0] for row in rows)
        assert found == pytest.approx(mean, rel=5e-4)


@pytest.mark.parametrize(("race", "side"), [("outer", -1), ("inner", 1), ("roller", -1)])
def test_a_spall_begins_where_the_rollers_come_from(race, side):
    """They run towards +s on the outer race and over a roller's surface, towards -s on the inner race."""
    young = case(defect=SHORT | {"shape": "spall", "race": race, "grown": "0 %"})
    model = assemble.model(young)
    assert np.sign(passing_speed(model.defects, 0, model.bearing)) == -side
    (found, *_) = roller_defect_pairs(young)
    low, high = found.paths[-1].pieces[0, 0], found.paths[-1].end
    assert side * low > 0.0
    assert side * high > 0.0


# Merged


def test_two_slots_side_by_side_are_one():
    """0.4 mm and 0.4 mm, touching: as one of 0.8 mm, whose middle is between them."""
    apart = np.degrees(4e-4 / R_O)
    half = SLOT | {"width": "0.4001 mm"}
    pair = [half | {"angle": "5 deg"}, half | {"angle": f"{5 + apart} deg"}]
    found, one = packed_defects(case(defects=pair)), packed_defects(case(defect=SLOT))
    assert len(found.head) == 1
    assert np.degrees(found.head[0, ANGLE]) == pytest.approx(5 + apart / 2)
    assert sunk(found, 0.0) == pytest.approx(sunk(one, 0.0), rel=1e-3)
    assert found.head[0, CUSP] == pytest.approx(0.0, abs=1e-9)


def test_a_merged_defect_is_the_same_wherever_it_is_counted_from():
    """Across the load line's far side, in either order, on either race and on a roller."""
    for on in ({}, {"race": "inner"}, {"race": "roller"}):
        for angles in ((179.8, -179.9), (10.0, 10.3)):
            pair = [SHORT | on | {"angle": f"{angle} deg", "offset": f"{n} mm"} for n, angle in enumerate(angles)]
            one, other = packed_defects(case(defects=pair)), packed_defects(case(defects=pair[::-1]))
            assert len(one.head) == (2 if on.get("race") == "roller" else 1)
            assert np.cos(one.head[0, ANGLE] - other.head[0, ANGLE]) == pytest.approx(1.0, abs=1e-15)
            s = np.linspace(-6e-4, 6e-4, 31)
            assert [sunk(one, x) for x in s] == pytest.approx([sunk(other, x) for x in s], rel=1e-9, abs=1e-15)


def test_side_by_side_along_the_roller_is_one_meeting_too():
    """A roller meets both at once, with two lengths of it."""
    pair = [SHORT | {"offset": "-3 mm"}, SHORT | {"offset": "3 mm", "depth": "0.2 um"}]
    found = packed_defects(case(defects=pair))
    alone = [packed_defects(case(defect=defect)) for defect in pair]
    assert len(found.head) == 1
    for s in (0.0, 2e-4, -3.9e-4):
        assert sunk(found, s) == pytest.approx(sum(sunk(one, s) for one in alone), rel=1e-9)


def test_defects_apart_stay_apart_with_their_closed_forms():
    found = packed_defects(case(defects=[SLOT, SLOT | {"angle": "1.3 deg"}, SLOT | {"race": "inner"}]))
    assert len(found.head) == 3
    assert isinstance(found.excitation, Envelope)


def test_a_merged_defects_shortest_part_says_how_long_a_crossing_takes():
    pair = [SLOT, SLOT | {"width": "0.2 mm", "angle": f"{np.degrees(4.5e-4 / R_O)} deg"}]
    found = packed_defects(case(defects=pair))
    assert 2 * found.head[0, HALF_WIDTH] == pytest.approx(9.5e-4, rel=1e-9)
    assert found.head[0, SPAN] == pytest.approx(2e-4, rel=1e-9)


def test_too_much_for_one_roller_is_refused():
    """Ten slots of 1.8 mm in a chain: refused by the case; by the defects if it is only what the edges add."""
    edged = SLOT | {"width": "9.2 mm", "edge": {"radius": "0.2 mm"}}
    pair = [edged, edged | {"angle": f"{np.degrees(9.5e-3 / R_O)} deg"}]
    with pytest.raises(Refused, match="mm between two contacts; make them narrower, or the edge's radius smaller"):
        packed_defects(case(defects=pair))


def test_what_a_ball_does_not_reach_is_refused_with_advice():
    defect = {"shape": "rectangular", "length": "0.5 mm", "width": "0.8 mm", "depth": "50 um", "offset": "2 mm"}
    with pytest.raises(SimulationError, match=r"has no depth; the contact ends 0\.\d+ mm from the middle; use"):
        simulate(case(bearing="6205", defect=defect))


# Traced


@pytest.mark.parametrize("shape", ["rectangular", "triangular", "circular"])
@pytest.mark.parametrize("depth", ["50 um", "2 um"])
def test_a_traced_defect_is_its_closed_form(shape, depth):
    """A spall far away makes a case trace all of its defects."""
    defect = SHORT | {"shape": shape, "depth": depth}
    far = SHORT | {"shape": "spall", "angle": "90 deg"}
    found, expected = packed_defects(case(defects=[defect, far])), packed_defects(case(defect=defect))
    assert isinstance(found.excitation, TracedPath)
    s = np.linspace(-5e-4, 5e-4, 101)
    assert [sunk(found, x) for x in s] == pytest.approx([sunk(expected, x) for x in s], rel=1e-9, abs=1e-18)


def test_rollers_over_a_traced_slot_move_as_over_its_closed_form():
    """One ball pass; forces, that jump at the cusp, to 1e-6 of the largest."""
    model = assemble.align_with_cusp(assemble.model(case(defect=SLOT)), 6289, 0.5)
    (slot,) = roller_defect_pairs(case(defect=SLOT))
    defect = Rectangular(12e-3, 8e-4, 5e-5)
    rows, paths = group_paths(defect, slot.R, cut_along_roller(defect, 12e-3, 6))
    by_table = model._replace(defects=pack_traced_defects([slot._replace(groups=rows, paths=paths)]))
    expected, found = (drive(one, Verlet(1e-6), 6289, at_rest(one)) for one in (model, by_table))
    scale = np.abs(expected).max(axis=1, keepdims=True) + 1e-12
    assert expected[4].max() > 1000.0  # the ring is struck
    assert found / scale == pytest.approx(expected / scale, abs=1e-6)


def test_shapes_of_the_same_sizes_are_told_apart():
    """Tuples of the same numbers are equal in Python."""
    sizes = (3e-3, 8e-4, 2e-6)
    box, groove, bowl = (
        group_paths(kind(*sizes), 7e-3, [(1.0, 0.0)])[1][0] for kind in (Rectangular, Triangular, Circular)
    )
    assert len({path.pieces.tobytes() for path in (box, groove, bowl)}) == 3


def test_defects_are_kept_in_step_by_their_cusp():
    """The cusp of a slot with a low step on one side is off its middle."""
    pair = [SLOT, SLOT | {"depth": "0.5 um", "angle": f"{np.degrees(7.9e-4 / R_O)} deg"}]
    model = assemble.model(case(defects=pair))
    head = model.defects.head[0]
    assert abs(head[CUSP]) > 1e-5
    stepped = assemble.align_with_cusp(model, 1000, 0.5)
    place = head[ANGLE] + head[CUSP] / R_O
    steps = (stepped.bearing.theta_0 - place) / (2 * pi / 13) * 1000
    assert steps - np.floor(steps) == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("shape", ["elliptical", "spall"])
def test_a_contact_over_a_defect_gives_back_the_work_it_takes(shape):
    """Without damping the force along rolling, sum Q dh/ds, adds up to nothing at a held approach."""
    defects = packed_defects(
        case(defect=SHORT | {"shape": shape, "width": "1 mm", "depth": "3 um", "edge": {"radius": "20 um"}})
    )
    contact = HuntCrossley(palmgren(12e-3), 0.0)
    s = np.linspace(-6e-4, 6e-4, 10001)
    sideways = np.array([force_over_defect(contact, defects, 0, x, 0.0, 4e-7, 0.0)[1] for x in s])
    assert np.abs(sideways).max() > 0.01
    assert abs(sideways.sum()) < 2e-3 * np.abs(sideways).sum()


# Slices


ZETAS = (-5.5e-3, -2e-3, -0.5e-3, 0.0, 1e-3, 5.5e-3)


@pytest.mark.parametrize(
    "more",
    [{}, {"shape": "triangular"}, {"shape": "circular"}, {"shape": "elliptical"}, {"edge": {"ramp": "30 um"}}],
)
def test_a_group_for_each_slice(more):
    found = packed_defects(case(defect=SHORT | {"offset": "0.5 mm"} | more), ZETAS)
    rows = found.groups[0]
    assert int(found.head[0, GROUP_COUNT]) == len(rows) == len(ZETAS)
    assert rows[:, GROUP_WEIGHT] == pytest.approx(np.ones(len(ZETAS)))
    on = [abs(z - 0.5e-3) < 1.5e-3 for z in ZETAS]
    assert [row[GROUP_HALF_WIDTH] > 0.0 for row in rows] == on
    sunk_there = [
        defect_response(found.excitation, row, 0.0, found.head[0, REDUCED_RADIUS])[1] > 0.0 for row in rows
    ]
    assert sunk_there == on


def test_other_excitations_in_slices():
    found = packed_defects(case(defect=SHORT, excitation="half-sine-pulse"), ZETAS)
    assert found.groups[0, 3, GROUP_HALF_WIDTH] == 4e-4
    with pytest.raises(ValueError, match="`pressure-share` has no form for slices; take `excitation: envelope`"):
        packed_defects(case(defect=SHORT, excitation="pressure-share", model="ring"), ZETAS)


def test_slices_add_up_to_the_groups():
    zetas = (np.arange(2400) + 0.5) / 2400 * 12e-3 - 6e-3
    for more in ({"shape": "elliptical"}, {"shape": "circular", "edge": {"radius": "20 um"}}):
        defect = case(defect=SHORT | more)
        whole, slices = packed_defects(defect), packed_defects(defect, zetas)
        for s in (0.0, 2e-4):
            mean = np.mean(
                [
                    defect_response(slices.excitation, row, s, slices.head[0, REDUCED_RADIUS])[1]
                    for row in slices.groups[0]
                ]
            )
            assert sunk(whole, s) == pytest.approx(mean, rel=2e-3)


# Impulses


def test_impulses_of_a_traced_slot():
    """The ring's impulses at a slot with edges rounded by nothing to speak of are those of the slot."""
    fields = {"model": "impulse", "excitation": "impulse-train"}
    sharp, eased = (
        assemble.model(case(defect=SLOT | edge, **fields)) for edge in ({}, {"edge": {"radius": "0.001 um"}})
    )
    assert eased.J_x == pytest.approx(sharp.J_x, rel=1e-4)
