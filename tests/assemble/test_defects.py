"""Defects of a case as roller-defect pairs: offset, merged, traced, in slices."""

from math import asin, pi, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from bearingsim import assemble
from bearingsim.assemble.defects import pack_case_defects, pair_defects
from bearingsim.assemble.rest import largest_load
from bearingsim.core.defects.closed_forms import make_groups, roller_drop
from bearingsim.core.defects.depth import Circular, Rectangular, Triangular
from bearingsim.core.defects.excitations import Envelope, TracedPath, defect_response
from bearingsim.core.defects.on_roller import force_over_defect, is_masked, mean_response
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
from bearingsim.core.defects.traced import cut_along_roller, pack_traced_defects, trace_groups
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.stiffness.power_laws import make_palmgren
from bearingsim.core.methods.verlet import Verlet
from bearingsim.errors import Refused
from bearingsim.simulation.simulate import SimulationError, simulate
from tests.scenes.nf308 import SLOT, at_rest, case, drive

SHORT = SLOT | {"length": "3 mm"}
BOWL = SHORT | {"shape": "circular"}
R_O = 0.0385


def mean_drop(defects, s, d=0):
    """Return the mean drop (m) of a roller at ``s`` (m) from the middle of one roller-defect pair."""
    return mean_response(defects, d, s)[0]


@pytest.mark.parametrize("shape", ["rectangular", "triangular", "circular"])
def test_offset_does_not_matter_within_the_roller(shape):
    centred, offset = (
        pack_case_defects(case(defect=SHORT | {"shape": shape, "offset": offset_text}))
        for offset_text in ("0 mm", "-4.5 mm")
    )
    s = np.linspace(-5e-4, 5e-4, 41)
    assert [mean_drop(offset, x) for x in s] == pytest.approx(
        [mean_drop(centred, x) for x in s], rel=1e-12, abs=1e-18
    )
    assert isinstance(offset.excitation, Envelope)


@pytest.mark.parametrize("offset", ["5.5 mm", "-5.5 mm"])
def test_part_beyond_the_roller_end_does_not_act(offset):
    """A defect of 3 mm with its middle 0.5 mm from the roller's end has 2 mm on the roller."""
    packed = pack_case_defects(case(defect=SHORT | {"offset": offset}))
    row = np.array([1.0, 4e-4, 1.0, 0.0, 5e-5])
    assert mean_drop(packed, 1e-4) == pytest.approx(
        2 / 12 * roller_drop(row, 1e-4, packed.head[0, REDUCED_RADIUS])[0], rel=1e-12
    )


@pytest.mark.parametrize("offset", [0.0, 4.9e-3, -5.5e-3, 6.5e-3])
def test_weights_of_a_bowl_equal_its_overlap_with_the_roller(offset):
    """The reference has 20000 slices of equal length."""
    R, length, width, depth, L_w = 7.1e-3, 3e-3, 8e-4, 5e-5, 12e-3
    rows = make_groups(Circular(length, width, depth), L_w, R, 24, offset)
    assert sum(row[GROUP_WEIGHT] for row in rows) == pytest.approx(1.0, rel=1e-12)
    z = (np.arange(20000) + 0.5) / 20000 * L_w - L_w / 2
    zeta = 2 * (z - offset) / length
    b = width / 2 * np.sqrt(np.maximum(1 - zeta**2, 0.0))
    for s in (0.0, 1.5e-4):
        mean = np.mean(np.maximum(b - s, 0.0) ** 2 / (2 * R))  # narrow, so the roller rests on the rims
        total = sum(row[GROUP_WEIGHT] * roller_drop(np.array(row), s, R)[0] for row in rows)
        assert total == pytest.approx(mean, rel=5e-4)


@pytest.mark.parametrize(("race", "side"), [("outer", -1), ("inner", 1), ("roller", -1)])
def test_spall_starts_at_the_entry_side(race, side):
    """Rollers move towards +s on the outer race and over a roller's surface, towards -s on the inner race."""
    initial = case(defect=SHORT | {"shape": "spall", "race": race, "grown": "0 %"})
    model = assemble.model(initial)
    assert np.sign(passing_speed(model.defects, 0, model.bearing)) == -side
    (pair, *_) = pair_defects(initial)
    low, high = pair.paths[-1].pieces[0, 0], pair.paths[-1].end
    assert side * low > 0.0
    assert side * high > 0.0


# Merged


def test_touching_slots_equal_one_slot():
    """Two touching slots of 0.4 mm equal one of 0.8 mm with its middle between them."""
    spacing = np.degrees(4e-4 / R_O)
    half = SLOT | {"width": "0.4001 mm"}
    pair = [half | {"angle": "5 deg"}, half | {"angle": f"{5 + spacing} deg"}]
    merged, single = pack_case_defects(case(defects=pair)), pack_case_defects(case(defect=SLOT))
    assert len(merged.head) == 1
    assert np.degrees(merged.head[0, ANGLE]) == pytest.approx(5 + spacing / 2)
    assert mean_drop(merged, 0.0) == pytest.approx(mean_drop(single, 0.0), rel=1e-3)
    assert merged.head[0, CUSP] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("gap", [0.0, 2e-18, -2e-18])
@pytest.mark.parametrize("angle", [0.0, 0.7, 3.1, 6.2])
def test_rounding_of_an_angle_leaves_no_ridge_between_touching_slots(angle, gap):
    """Two slots of 0.4 mm, touching but for rounding: a ridge would carry a roller at s = 0. The drop by hand."""
    half = SLOT | {"width": "0.4 mm"}
    pair = [half | {"angle": angle}, half | {"angle": angle + (4e-4 + gap) / R_O}]
    packed, R = pack_case_defects(case(defects=pair)), 6e-3 * R_O / (R_O - 6e-3)
    for s in (0.0, 1e-4, -3e-4):
        assert mean_drop(packed, s) == pytest.approx((4e-4 - abs(s)) ** 2 / (2 * R), rel=1e-9)


def test_merging_does_not_depend_on_the_order():
    """Pairs in both orders, on both races and on a roller, also across 180 deg."""
    for carrier in ({}, {"race": "inner"}, {"race": "roller"}):
        for angles in ((179.8, -179.9), (10.0, 10.3)):
            pair = [
                SHORT | carrier | {"angle": f"{angle} deg", "offset": f"{n} mm"} for n, angle in enumerate(angles)
            ]
            packed, reverse_packed = (
                pack_case_defects(case(defects=pair)),
                pack_case_defects(case(defects=pair[::-1])),
            )
            assert len(packed.head) == (2 if carrier.get("race") == "roller" else 1)
            assert np.cos(packed.head[0, ANGLE] - reverse_packed.head[0, ANGLE]) == pytest.approx(1.0, abs=1e-15)
            s = np.linspace(-6e-4, 6e-4, 31)
            assert [mean_drop(packed, x) for x in s] == pytest.approx(
                [mean_drop(reverse_packed, x) for x in s], rel=1e-9, abs=1e-15
            )


def test_defects_side_by_side_along_the_roller_form_one_pair():
    """Both act on the roller at once, on different parts of its length."""
    pair = [SHORT | {"offset": "-3 mm"}, SHORT | {"offset": "3 mm", "depth": "0.2 um"}]
    merged = pack_case_defects(case(defects=pair))
    singles = [pack_case_defects(case(defect=defect)) for defect in pair]
    assert len(merged.head) == 1
    for s in (0.0, 2e-4, -3.9e-4):
        assert mean_drop(merged, s) == pytest.approx(sum(mean_drop(single, s) for single in singles), rel=1e-9)


def test_separate_defects_have_closed_forms():
    packed = pack_case_defects(case(defects=[SLOT, SLOT | {"angle": "1.3 deg"}, SLOT | {"race": "inner"}]))
    assert len(packed.head) == 3
    assert isinstance(packed.excitation, Envelope)


def test_span_is_that_of_the_shortest_merged_defect():
    pair = [SLOT, SLOT | {"width": "0.2 mm", "angle": f"{np.degrees(4.5e-4 / R_O)} deg"}]
    packed = pack_case_defects(case(defects=pair))
    assert 2 * packed.head[0, HALF_WIDTH] == pytest.approx(9.5e-4, rel=1e-9)
    assert packed.head[0, SPAN] == pytest.approx(2e-4, rel=1e-9)


def test_defect_wider_than_the_roller_spacing_is_rejected():
    """The edges make the merged defect wider than the spacing, which the case does not check."""
    edged = SLOT | {"width": "9.2 mm", "edge": {"radius": "0.2 mm"}}
    pair = [edged, edged | {"angle": f"{np.degrees(9.5e-3 / R_O)} deg"}]
    with pytest.raises(
        Refused, match=r"deg act over .* mm between two contacts; make them narrower, or the edge's radius smaller"
    ):
        pack_case_defects(case(defects=pair))


def test_defect_outside_the_contact_of_a_ball_is_rejected():
    defect = {"shape": "rectangular", "length": "0.5 mm", "width": "0.8 mm", "depth": "50 um", "offset": "2 mm"}
    with pytest.raises(SimulationError, match=r"has no depth; the contact ends 0\.\d+ mm from its centre; use"):
        simulate(case(bearing="6205", defect=defect))


# Traced


@pytest.mark.parametrize("shape", ["rectangular", "triangular", "circular"])
@pytest.mark.parametrize("depth", ["50 um", "2 um"])
def test_traced_defect_equals_its_closed_form(shape, depth):
    """A distant spall requires a case to trace all of its defects."""
    defect = SHORT | {"shape": shape, "depth": depth}
    distant = SHORT | {"shape": "spall", "angle": "90 deg"}
    packed, expected = pack_case_defects(case(defects=[defect, distant])), pack_case_defects(case(defect=defect))
    assert isinstance(packed.excitation, TracedPath)
    s = np.linspace(-5e-4, 5e-4, 101)
    assert [mean_drop(packed, x) for x in s] == pytest.approx(
        [mean_drop(expected, x) for x in s], rel=1e-9, abs=1e-18
    )


def test_traced_slot_gives_the_motion_of_the_closed_form():
    """Forces agree to 1e-6 of the largest over one ball pass, although they jump at the cusp."""
    model = assemble.align_with_cusp(assemble.model(case(defect=SLOT)), 6289, 0.5)
    (slot,) = pair_defects(case(defect=SLOT))
    defect = Rectangular(12e-3, 8e-4, 5e-5)
    rows, paths = trace_groups(defect, slot.R, cut_along_roller(defect, 12e-3, 6))
    by_table = model._replace(defects=pack_traced_defects([slot._replace(groups=rows, paths=paths)]))
    expected, result = (drive(variant, Verlet(1e-6), 6289, at_rest(variant)) for variant in (model, by_table))
    scale = np.abs(expected).max(axis=1, keepdims=True) + 1e-12
    assert expected[4].max() > 1000.0  # an impact occurs
    assert result / scale == pytest.approx(expected / scale, abs=1e-6)


def test_shapes_of_equal_sizes_are_cached_separately():
    """Named tuples of different types with the same numbers are equal in Python."""
    sizes = (3e-3, 8e-4, 2e-6)
    box, groove, bowl = (
        trace_groups(kind(*sizes), 7e-3, [(1.0, 0.0)])[1][0] for kind in (Rectangular, Triangular, Circular)
    )
    assert len({path.pieces.tobytes() for path in (box, groove, bowl)}) == 3


def test_rollers_are_aligned_with_the_cusp():
    """The cusp of a slot with a low step on one side is not in its middle."""
    pair = [SLOT, SLOT | {"depth": "0.5 um", "angle": f"{np.degrees(7.9e-4 / R_O)} deg"}]
    model = assemble.model(case(defects=pair))
    head = model.defects.head[0]
    assert abs(head[CUSP]) > 1e-5
    aligned = assemble.align_with_cusp(model, 1000, 0.5)
    cusp_angle = head[ANGLE] + head[CUSP] / R_O
    steps = (aligned.bearing.theta_0 - cusp_angle) / (2 * pi / 13) * 1000
    assert steps - np.floor(steps) == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("shape", ["elliptical", "spall"])
def test_undamped_crossing_does_no_work(shape):
    """Without damping the integral of the force along rolling, sum Q dh/ds, is zero at constant approach."""
    defects = pack_case_defects(
        case(defect=SHORT | {"shape": shape, "width": "1 mm", "depth": "3 um", "edge": {"radius": "20 um"}})
    )
    contact = HuntCrossley(make_palmgren(12e-3), 0.0)
    s = np.linspace(-6e-4, 6e-4, 10001)
    sideways = np.array([force_over_defect(contact, defects, 0, x, 0.0, 4e-7, 0.0)[1] for x in s])
    assert np.abs(sideways).max() > 0.01
    assert abs(sideways.sum()) < 2e-3 * np.abs(sideways).sum()


# Slices


ZETAS = (-5.5e-3, -2e-3, -0.5e-3, 0.0, 1e-3, 5.5e-3)


@pytest.mark.parametrize(
    "changes",
    [{}, {"shape": "triangular"}, {"shape": "circular"}, {"shape": "elliptical"}, {"edge": {"ramp": "30 um"}}],
)
def test_a_group_for_each_slice(changes):
    packed = pack_case_defects(case(defect=SHORT | {"offset": "0.5 mm"} | changes), ZETAS)
    rows = packed.groups[0]
    assert int(packed.head[0, GROUP_COUNT]) == len(rows) == len(ZETAS)
    assert rows[:, GROUP_WEIGHT] == pytest.approx(np.ones(len(ZETAS)))
    in_slice = [abs(z - 0.5e-3) < 1.5e-3 for z in ZETAS]
    assert [row[GROUP_HALF_WIDTH] > 0.0 for row in rows] == in_slice
    has_drop = [
        defect_response(packed.excitation, row, 0.0, packed.head[0, REDUCED_RADIUS])[1] > 0.0 for row in rows
    ]
    assert has_drop == in_slice


def test_other_excitations_in_slices():
    packed = pack_case_defects(case(defect=SHORT, excitation="half-sine-pulse"), ZETAS)
    assert packed.groups[0, 3, GROUP_HALF_WIDTH] == 4e-4
    with pytest.raises(
        ValueError, match="`pressure-share` cannot act on sliced rollers; use `excitation: envelope`"
    ):
        pack_case_defects(case(defect=SHORT, excitation="pressure-share", model="ring"), ZETAS)


def test_mean_of_slices_equals_the_groups():
    middles = (np.arange(2400) + 0.5) / 2400 * 12e-3 - 6e-3
    for changes in ({"shape": "elliptical"}, {"shape": "circular", "edge": {"radius": "20 um"}}):
        defect = case(defect=SHORT | changes)
        groups, slices = pack_case_defects(defect), pack_case_defects(defect, middles)
        for s in (0.0, 2e-4):
            mean = np.mean(
                [
                    defect_response(slices.excitation, row, s, slices.head[0, REDUCED_RADIUS])[1]
                    for row in slices.groups[0]
                ]
            )
            assert mean_drop(groups, s) == pytest.approx(mean, rel=2e-3)


# Impulses


def test_impulses_of_a_traced_slot():
    """Impulses at a slot with a negligible edge radius equal those at a sharp slot."""
    fields = {"model": "impulse", "excitation": "impulse-train"}
    sharp, eased = (
        assemble.model(case(defect=SLOT | edge, **fields)) for edge in ({}, {"edge": {"radius": "0.001 um"}})
    )
    assert eased.J_x == pytest.approx(sharp.J_x, rel=1e-4)


@pytest.mark.parametrize("bearing", ["nf308", "6205"])
@pytest.mark.parametrize("race", ["outer", "inner"])
def test_pressure_share_has_the_contact_of_the_damaged_race(bearing, race):
    """Hertz's contact is narrower on the inner race; its pressure over a dent of 10 um is integrated here."""
    dented = case(
        bearing=bearing,
        defect=SLOT | {"race": race, "length": "5 mm", "width": "10 um"},
        excitation="pressure-share",
    )
    b, sign = dented.bearing, 1.0 if race == "inner" else -1.0
    omega_c = 30.0 * pi * (1.0 - b.roller_diameter / b.pitch_diameter)
    centrifugal = b.element_mass * omega_c**2 * b.pitch_diameter / 2.0
    load, E_star = largest_load(dented), b.material.young_modulus / (2.0 * (1.0 - 0.3**2))
    load -= centrifugal if race == "inner" else 0.0
    R_race, R_w = (b.pitch_diameter - sign * b.roller_diameter) / 2.0, b.roller_diameter / 2.0
    along = 1.0 / R_w + sign / R_race
    if bearing == "nf308":
        assert b.roller_length is not None
        half = sqrt(4.0 * load / along / (pi * b.roller_length * E_star))
    else:
        groove = b.inner_groove_radius if race == "inner" else b.outer_groove_radius
        assert groove is not None
        half = hertz_half_width(load, E_star, along, 1.0 / R_w - 1.0 / groove)
    x = 5e-6 / half
    packed = pack_case_defects(dented)
    groups = packed.groups[0, : int(packed.head[0, GROUP_COUNT])]
    shares = [defect_response(packed.excitation, group, 0.0, packed.head[0, REDUCED_RADIUS]) for group in groups]
    over_dent = [share for share, drop, _ in shares if drop > 0.0]
    assert over_dent == pytest.approx([2.0 * (asin(x) + x * sqrt(1.0 - x * x)) / pi], rel=1e-6)


def test_dents_that_share_a_contact_are_rejected():
    """Two dents of 8 um, touching, would have the share of one instead of that of a dent of 16 um."""
    dent = SLOT | {"width": "8 um", "depth": "5 um"}
    near, far = ([dent, dent | {"angle": distance / R_O}] for distance in (8e-6, 1e-4))
    with pytest.raises(Refused, match=r"dents at 0 and 0.01191 deg are 8 um apart, so a contact may cover parts"):
        pack_case_defects(case(defects=near, excitation="pressure-share"))
    assert len(pack_case_defects(case(defects=far, excitation="pressure-share")).head) == 2
    other_race = [dent, dent | {"race": "inner"}]
    assert len(pack_case_defects(case(defects=other_race, excitation="pressure-share")).head) == 2


@pytest.mark.parametrize("order", [1, -1])
def test_the_softer_of_two_edges_acts_on_a_ridge(order):
    """Two slots with a ridge of 20 um: 4 um from the rim of one, 16 um from that of the other."""
    slot = SLOT | {"width": "0.2 mm"}
    fields = {"defects": [slot, slot | {"angle": 2.2e-4 / R_O}][::order], "excitation": "elastic-edge"}
    for s, acting in ((1.04e-4, 0), (1.16e-4, 1)):
        model = assemble.model(case(start_angle=s / R_O, **fields))
        positions = (s, s - 2.2e-4)[::order]
        y = assemble.empty_buffer(model)
        masked = [is_masked(model, d, 0, position, 0.0, y) for d, position in enumerate(positions)]
        assert masked[::order] == [acting == 1, acting == 0]


def hertz_half_width(Q, E_star, steep, flat):
    """Return the shorter semi-axis (m) of Hertz's ellipse from SciPy's elliptic integrals."""
    shape = lambda m: ((ellipe(m) / (1.0 - m) - ellipk(m)) / (ellipk(m) - ellipe(m))) - steep / flat  # noqa: E731
    m = brentq(shape, 1e-6, 1.0 - 1e-9)
    a_cubed = 3.0 * Q * ellipe(m) / (2.0 * pi * E_star * (1.0 - m) * (steep + flat) / 2.0)
    return a_cubed ** (1.0 / 3.0) * sqrt(1.0 - m)
