"""The outer ring at rest as it is drawn: its shape, how far it is enlarged, what is marked on and around it."""

import math
from typing import Any

import numpy as np
import pytest

from bearingsim import assemble, store
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.figure_kinds import OptionError
from bearingsim.plots import PlotError, PlotWarning
from bearingsim.plots import plot as written
from bearingsim.plots.plot import draw_figures
from bearingsim.plots.ring import draw_shape, make_view, sensor_position
from bearingsim.plots.ring_shape import FRACTIONS, ring_shape
from bearingsim.plots.select import case_rows, done_jobs
from tests.scenes.figure_results import STUDY, only, results
from tests.scenes.nf308 import SLOT

__all__ = ["results"]

BENDS = {"ring": {"bends": True}}
PADS = BENDS | {"load": {"by": "pads", "angles": ["-45 deg", "45 deg"]}}
HOUSING = BENDS | {"load": {"by": "housing", "stiffness": "1e10 N/m/m"}}
POINTS = BENDS | {"load": {"by": "points", "at": [{"angle": f"{a} deg", "stiffness": "1e8 N/m"} for a in
                                                   (-60, 0, 60, 180)]}}  # fmt: skip
AROUND = np.radians(np.arange(-180.0, 180.0, 7.0))


def case(rig=None, **fields):
    defect = {} if "defects" in fields else {"defect": SLOT}
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "rollers"}
    return Case.model_validate(base | defect | fields | ({"rig": rig} if rig else {}))


def settled(test_case, part):
    """The buffer of a case at rest: a roller over a defect at 0 deg, and ``part`` of a ball pass later."""
    model = assemble.model(test_case)
    y, b = assemble.empty_buffer(model), model.bearing
    assemble.find_equilibrium(model, (part * 2.0 * math.pi / b.Z - b.theta_0) / b.omega_c, y, from_scratch=True)
    return y


@pytest.mark.parametrize("rig", [BENDS, HOUSING])
@pytest.mark.parametrize("number", [0, 1])
def test_ring_shape_is_sum_of_static_harmonics(rig, number):
    test_case = case(rig)
    instant = ring_shape(test_case).instants[number]
    y = settled(test_case, FRACTIONS[number])
    c, s, (x, z) = lay.POSITION + lay.MODES_C, lay.POSITION + lay.MODES_S, y[:2]
    orders = [*range(2, int(test_case.rig.ring.harmonics) + 1), 0]
    bent = [sum(y[c + i] * math.cos(n * angle) + y[s + i] * math.sin(n * angle) for i, n in enumerate(orders))
            for angle in AROUND]  # fmt: skip
    assert max(np.abs(bent)) > 2e-8
    assert instant.bending(AROUND) == pytest.approx(bent, rel=1e-6, abs=1e-14)
    total = [w + x * math.cos(angle) + z * math.sin(angle) for w, angle in zip(bent, AROUND, strict=True)]
    assert instant.displacement(AROUND) == pytest.approx(total, rel=1e-6, abs=1e-14)
    assert instant.forces @ np.cos(instant.angles) == pytest.approx(150.0, rel=0.05)  # less what the bracket takes


def test_ring_deflects_inwards_and_roller_over_defect_is_unloaded():
    over, beside, *_ = ring_shape(case(BENDS)).instants
    nearest = int(np.argmin(np.abs(over.angles)))
    assert over.angles[nearest] == pytest.approx(0.0, abs=1e-9)
    assert not over.loaded[nearest]
    assert over.bending(np.zeros(1)) < 2.0 * beside.bending(np.zeros(1)) < -1e-7
    turned = (beside.angles - over.angles + math.pi) % (2.0 * math.pi) - math.pi
    assert turned == pytest.approx(np.full(13, 2.0 * math.pi / 13 / 4))
    assert np.abs(over.outwards).max() < 3e-6  # what it sinks into the defect, 10 um, is left out


def line(ax, gid):
    return next(curve for curve in ax.lines if curve.get_gid() == gid)


@pytest.mark.parametrize(
    ("rig", "clearance", "times"),
    [(BENDS, "0 um", 2000.0), (PADS, "2 um", 1000.0), (HOUSING, "0 um", 5000.0), (None, "0 um", 5000.0)],
)
def test_deformation_is_drawn_at_labelled_scale(rig, clearance, times):
    shape = ring_shape(case(rig, clearance=clearance))
    canvas = draw_shape(shape, [])
    title = canvas.legends[0].get_title().get_text()
    assert title == f"Ring at rest; displacements and clearance ×{times:.0f}"
    sound = 1e3 * (38.5e-3 + times * shape.gap)
    for ax, instant in zip(canvas.axes, shape.instants, strict=False):
        right, up = (np.asarray(part) for part in line(ax, "race").get_data())
        angles = np.linspace(-math.pi, math.pi, len(up))
        outwards = -right * np.sin(angles) + up * np.cos(angles) - sound  # along the undeformed radius
        assert outwards == pytest.approx(1e3 * times * instant.displacement(angles), abs=1e-9)
    assert np.max(np.abs(outwards)) < 0.11 * 45.0


def test_scale_is_a_round_number_that_fits_displacement():
    """9 mm of 90 mm, so that what is largest at 2.2 um may be 4.5 mm."""
    shape = ring_shape(case(BENDS))
    assert make_view(shape).exaggeration == 2000.0
    half = shape._replace(instants=tuple(
        instant._replace(x=0.5 * instant.x, y=0.5 * instant.y, a=0.5 * instant.a, b=0.5 * instant.b,
                         outwards=0.5 * instant.outwards)
        for instant in shape.instants
    ), gap=0.0)  # fmt: skip
    assert make_view(half).exaggeration in (2000.0, 5000.0)
    assert 0.04 * 45e-3 < make_view(half).exaggeration * half.largest() <= 0.1 * 45e-3


def circles(ax):
    return {int(patch.get_gid().split()[1]) - 1: patch for patch in ax.patches if patch.get_gid()}


def test_rollers_are_shaded_by_force_and_touch_drawn_race():
    shape = ring_shape(case(BENDS))
    seen, canvas = make_view(shape), draw_shape(shape, [])
    for ax, instant in zip(canvas.axes, shape.instants, strict=False):
        patches = circles(ax)
        order = np.argsort(instant.forces)
        dark = [sum(patches[int(j)].get_facecolor()[:3]) for j in order]
        assert dark[0] == 3.0
        assert dark[-1] < 1.2
        for j in np.flatnonzero(~instant.loaded):
            assert patches[int(j)].get_facecolor()[:3] == (1.0, 1.0, 1.0)
            right, up = np.asarray(patches[int(j)].center)
            outer = np.hypot(right, up) + 6.0
            bent = seen.race + 1e3 * seen.exaggeration * instant.displacement(instant.angles[j])
            assert outer == pytest.approx(bent, abs=0.1)


def test_defects_are_marked_at_their_angle():
    defects = [SLOT | {"angle": "20 deg"}, SLOT | {"race": "inner", "angle": "30 deg"},
            SLOT | {"race": "roller", "roller": 2}]  # fmt: skip
    test_case = case(defects=defects)
    shape = ring_shape(test_case)
    model = assemble.model(test_case)
    b, angle = model.bearing, math.radians(20.0)
    first = ((angle - b.theta_0) % (2.0 * math.pi / 13)) / b.omega_c
    for part, instant in zip(FRACTIONS, shape.instants, strict=True):
        t = first + part * 2.0 * math.pi / 13 / b.omega_c
        on = {mark.on: mark for mark in instant.marks}
        assert on["outer"].angle == pytest.approx(angle)
        assert on["outer"].half == pytest.approx(0.4e-3 / b.R_o)
        assert on["inner"].angle == pytest.approx(math.radians(30.0) + b.omega_i * t)
        assert on["roller"].roller == 1
        own = on["roller"].angle - instant.angles[1] + b.omega_b * t
        assert math.sin(own) == pytest.approx(0.0, abs=1e-9)
    ax = draw_shape(shape, []).axes[0]
    right, up = (np.asarray(part) for part in line(ax, "defect").get_data())
    assert math.atan2(-right[10], up[10]) == pytest.approx(angle, abs=0.02)


@pytest.mark.parametrize(
    ("rig", "pushes"),
    [(BENDS, [(0.0, 150.0)]), (PADS, [(-45.0, 106.066), (45.0, 106.066)]), (HOUSING, [(0.0, 150.0)])],
)
def test_arrows_are_at_forces(rig, pushes):
    shape = ring_shape(case(rig))
    acting = np.array([(math.degrees(push.angle), push.force) for push in shape.applied_forces])
    assert acting == pytest.approx(np.array(pushes), rel=1e-5)
    ax = draw_shape(shape, []).axes[0]
    words: Any = [text for text in ax.texts if text.get_gid() == "push"]
    assert [text.get_text() for text in words] == [f"{force:.0f} N" for _, force in pushes]
    for (angle, _), word in zip(pushes, words, strict=True):
        right, up = word.xy
        assert math.degrees(math.atan2(-right, up)) == pytest.approx(angle, abs=2.0)
        assert math.hypot(right, up) > 45.0


@pytest.mark.parametrize(("rig", "count"), [(HOUSING, 80), (POINTS, 4)])
def test_loaded_and_unloaded_springs_are_drawn_differently(rig, count):
    shape = ring_shape(case(rig))
    instant = shape.instants[0]
    assert len(instant.springs) == len(shape.spring_angles) == count
    pressed = shape.spring_angles[instant.springs > 0.0]
    assert 0 < len(pressed) < count
    assert np.abs(pressed).max() < 2.0
    assert instant.springs @ np.cos(shape.spring_angles) == pytest.approx(
        instant.forces @ np.cos(instant.angles), rel=1e-6
    )
    ax = draw_shape(shape, []).axes[0]
    assert sum(line.get_gid() == "pressed" for line in ax.lines) == len(pressed)
    assert sum(line.get_gid() == "lifted" for line in ax.lines) == count - len(pressed)


@pytest.mark.parametrize(("on", "least", "most"), [("ring", 38.0, 45.0), ("housing", 47.0, 53.0)])
def test_the_sensor_is_marked_at_its_angle(on, least, most):
    shape = ring_shape(case(POINTS | {"sensor": {"on": on, "angle": "30 deg"}}))
    right, up = (float(part[0]) for part in sensor_position(make_view(shape), shape.instants[0]))
    assert math.degrees(math.atan2(-right, up)) == pytest.approx(30.0, abs=4.0)
    assert least < math.hypot(right, up) < most


def test_ring_figure_per_job(results):
    """One of a rigid ring, and one whose model knows no rollers: left out, with a warning."""
    opened = results(STUDY.replace("[static, ring]", "[static, impulse]").replace("[3 mm, 6 mm, 9 mm]", "[3 mm]"))
    with pytest.warns(PlotWarning, match="skipped: the model `impulse` has no loaded rollers"):
        sheets = draw_figures(opened, kind="ring", jobs=["all"])
    rests = done_jobs(case_rows(opened).query("model == 'static'"))
    assert [name for name, _ in sheets] == [f"ring-{job[:8]}" for job in rests]
    caption = sheets[0][1].get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert "load 150 N" in caption
    assert "length 3 mm" in caption
    assert written(opened, kind="ring", jobs=rests[:1])[0].stat().st_size > 10_000


def test_flexible_ring_is_drawn_from_stored_results(results):
    text = STUDY.replace("[static, ring]", "[static]").replace("[3 mm, 6 mm, 9 mm]", "[3 mm]")
    opened = results(text.replace("[150 N, 300 N]", "[150 N]") + "rig: {ring: {bends: true}}\n")
    _, canvas = only(draw_figures(opened, kind="ring"))
    assert [ax.get_title(loc="left") for ax in canvas.axes[:4]] == [
        "(a) a roller over the defect",
        "(b) ¼ of a ball pass later",
        "(c) ½ later",
        "(d) ¾ later",
    ]


def test_undrawable_figure_is_refused(results):
    opened = results(STUDY.replace("[static, ring]", "[impulse]"), lost={0: "failed"})
    with pytest.raises(PlotError, match="`impulse` has no loaded rollers, so there is no ring at rest to draw"):
        draw_figures(opened, kind="ring", jobs=opened.jobs[1:2])
    with pytest.raises(store.ResultsError, match="no job nobody"):
        draw_figures(opened, kind="ring", jobs=["nobody"])
    with pytest.raises(store.ResultsError, match="has no series: the ring left"):
        draw_figures(opened, kind="ring", jobs=opened.jobs[:1])
    with pytest.raises(OptionError, match="a ring has no option `y`"):
        draw_figures(opened, kind="ring", y=["velocity.rms"])
