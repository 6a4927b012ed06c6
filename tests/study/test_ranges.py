"""Warnings beyond the range of validity of models, and refusals of unphysical values."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import root

from bearingsim import store
from bearingsim.assemble.form import contact_half_width
from bearingsim.assemble.rest import largest_load
from bearingsim.config import Case
from bearingsim.study import StudyError, load_study
from bearingsim.study.ranges import (
    MAX_SPEED_FACTOR,
    coarseness,
    contact_pressure,
    frequency,
    omission_warnings,
    preload_ratio,
    pressure,
    range_warnings,
    shortest_crossing,
    static_rating,
)
from tests.conftest import Write
from tests.scenes.commands import type_

BASE = """\
study: a
bearing: nf308
speed: 1800 rpm
duration: 0.1 s
rig: {ring: {bends: false}}
"""


def case(bearing: str, **values: object) -> Case:
    return Case.model_validate({"bearing": bearing, "speed": "1800 rpm", "load": "150 N", **values})


def warnings_of(write: Write, text: str) -> list[str]:
    return [note for note in load_study(write(BASE + text)).assumptions if note.startswith("warning: ")]


@pytest.mark.parametrize("race", ["outer", "inner", "roller"])
def test_a_width_is_crossed_in_the_same_time_on_each_element(race: str) -> None:
    """A rolling element rolls on both races, so the speed at the contact is that of the cage on the outer race."""
    defect = {"race": race, "shape": "circular", "length": "3 mm", "width": "0.8 mm", "depth": "0.05 mm"}
    cage = 0.5 * 60.0 * math.pi * (1.0 - 12.0 / 65.0)  # rad/s
    damaged = case("nf308", defects=[defect])
    assert shortest_crossing(damaged) == pytest.approx(0.8 / (cage * 38.5), rel=1e-12)
    assert coarseness(damaged) == pytest.approx(8.0 / (shortest_crossing(damaged) * 10240.0), rel=1e-12)
    assert coarseness(damaged.model_copy(update={"antialias": False})) == 0.0


@pytest.mark.parametrize(
    ("bearing", "printed"),  # kN: C0 of NU 210 ECP, 6205 and 6309 in SKF's catalogue
    [("nu210", 69.5), ("6205", 7.8), ("6309", 31.5)],
)
def test_static_rating_equals_the_catalogue(bearing: str, printed: float) -> None:
    assert static_rating(case(bearing)) == pytest.approx(1e3 * printed, rel=0.04)


@pytest.mark.parametrize("name", ["nf308", "nu210", "nu204"])
def test_contact_pressure_at_the_static_rating_is_4_gpa(name: str) -> None:
    """The rating is that of ISO 76, pressures are Hertz's: ISO 76 relates them by Q = 5 F/Z."""
    rated, bearing = case(name), case(name).bearing
    force = 5.0 * static_rating(rated) / bearing.rollers
    assert contact_pressure(bearing, force) == pytest.approx(4e9, rel=0.01)


def test_the_inner_race_does_not_carry_the_centrifugal_force() -> None:
    """NF308 at 12000 rpm and 150 N: 90.7 N per roller; the outer race then has the larger pressure."""
    fast = case("nf308", model="rollers", speed="12000 rpm", load="150 N")
    mass, omega_c = 7850.0 * math.pi * 6e-3**2 * 12e-3, 400.0 * math.pi * (1.0 - 12.0 / 65.0) / 2.0
    outer, inner = largest_load(fast), largest_load(fast, False)
    assert outer - inner == pytest.approx(mass * omega_c**2 * 0.0325, rel=1e-3)
    modulus = 207e9 / (2.0 * (1.0 - 0.3**2))
    at_outer, at_inner = (
        math.sqrt(force / 12e-3 * modulus * curvature / math.pi)
        for force, curvature in ((outer, 1.0 / 6e-3 - 1.0 / 38.5e-3), (inner, 1.0 / 6e-3 + 1.0 / 26.5e-3))
    )
    assert at_outer > at_inner
    assert pressure(fast) == pytest.approx(at_outer, rel=1e-9)
    radius = 1.0 / (1.0 / 6e-3 + 1.0 / 26.5e-3)
    assert contact_half_width(fast, False) == pytest.approx(
        math.sqrt(4.0 * inner / 12e-3 * radius / (math.pi * modulus))
    )


def test_a_preload_above_the_load_is_reported() -> None:
    """NF308: half of 25 um at each of Palmgren's contacts, and 2 F/Z more on the most loaded roller."""
    preloaded = case("nf308", clearance="-50 um")
    force = (12.5e-3 / 3.84e-5) ** (10 / 9) * 12 ** (8 / 9) + 2 * 150 / 13  # N
    assert preload_ratio(preloaded) == pytest.approx(force / 150, rel=5e-3)
    (warning,) = range_warnings([preloaded, case("nf308", clearance="50 um"), case("nf308")], [])
    text = "a preload of 50 um presses a roller with 5.66 kN at rest, more than the load of 0.15 kN (1 of 3 cases)"
    assert warning == f"warning: {text}"
    assert preload_ratio(case("nf308", clearance="-1 um", load="5 kN")) < 1.0


WAVE = {"order": 100, "amplitude": "0.1 um"}


def line_load_between_tilted_rings(tilt: float, load: float, count: int = 24) -> float:
    """Compute the largest line load (N/m) of an NF308 whose inner ring is tilted (rad) towards the load (N).

    Rollers without mass share the approach equally between Palmgren's contacts of both races, slice by slice; two
    forces on the outer ring balance. Terms of second order in the tilt are neglected.
    """
    length, pitch = 12e-3, 2.0 * np.pi / 13
    z = length * ((np.arange(count) + 0.5) / count - 0.5)

    def line_loads(position: Any, angles: Any) -> Any:
        radial = -position[0] * np.cos(angles) - position[1] * np.sin(angles)
        approach = np.maximum(radial[:, np.newaxis] + tilt * np.outer(np.cos(angles), z), 0.0) / 2.0
        return (1e3 * approach / 3.84e-5) ** (10 / 9) * 12 ** (8 / 9) / length

    def net_force(position: Any, angles: Any) -> Any:
        forces = line_loads(position, angles).mean(axis=1) * length
        return [forces @ np.cos(angles) - load, forces @ np.sin(angles)]

    largest = 0.0
    for part in (np.arange(32) + 0.5) / 32:
        angles = pitch * (part + np.arange(13))
        solution = root(net_force, [-1e-7, 0.0], args=(angles,), tol=1e-12)
        assert np.hypot(*net_force(solution.x, angles)) < 1e-6 * load
        largest = max(largest, line_loads(solution.x, angles).max())
    return largest


def test_pressure_of_misaligned_rollers_is_that_of_the_most_loaded_slice() -> None:
    """With E' of both bodies and the radius at the inner race, Hertz's line contact (Johnson, 4.45)."""
    modulus, radius = 207e9 / (2.0 * (1.0 - 0.3**2)), 1.0 / (1.0 / 6e-3 + 1.0 / 26.5e-3)
    tilted = case("nf308", model="spatial", misalignment={"inner": "1 mrad"})
    expected = math.sqrt(line_load_between_tilted_rings(1e-3, 150.0) * modulus / (math.pi * radius))
    assert pressure(tilted) == pytest.approx(expected, rel=0.01)
    assert pressure(tilted) > 2.0 * pressure(case("nf308", model="spatial"))
    wavy = case(
        "nf308", model="spatial", misalignment={"inner": "1 mrad"}, surfaces={"outer": {"harmonics": [WAVE]}}
    )
    reduced = 1.0 / (1.0 / 6e-3 - 1.0 / 38.5e-3)
    width = math.sqrt(4.0 * line_load_between_tilted_rings(1e-3, 150.0) * reduced / (math.pi * modulus))
    assert contact_half_width(wavy, True) == pytest.approx(width, rel=0.02)  # rollers without mass
    overloaded = case("nf308", model="spatial", load="30 kN", misalignment={"inner": "15 mrad"})
    (warning,) = range_warnings([overloaded], [])
    assert "would dent the races" in warning


def test_lines_are_at_the_frequencies_of_freq() -> None:
    """`bearingsim freq nf308`: orders 5.3 and 7.7 of BPFO and BPFI, 0.4077 of the cage."""
    test_case = case("nf308")
    orders = {"2BPFO": 10.6, "BPFI-fr": 6.7, "2BSF+FTF": 2.0 * 2.616 + 0.4077, "fr": 1.0}
    for name, order in orders.items():
        assert frequency(test_case, name) == pytest.approx(30.0 * order, rel=1e-3)


def test_values_in_range_cause_no_warning(write: Write) -> None:
    assert warnings_of(write, "load: 10 kN\nsweep: {speed: [1000 rpm, 14000 rpm]}\n") == []


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        (
            "sweep: {load: [1 kN, 70 kN, 95 kN]}",
            [
                "GPa at rest, above 4 GPa, would dent the races",
                "a load of 95 kN exceeds the static rating C0, about",
            ],
        ),
        (
            "load: 1 N\nload_across: 95 kN",
            ["GPa at rest, above 4 GPa, would dent the races", "a load of 95 kN exceeds the static rating C0"],
        ),
        ("load: 1 N\nspeed: 20000 rpm", ["20000 rpm is n d_m = 1.3e6 mm/min, above 1e6"]),
        (
            "load: 1 N\nmodel: planar\nramp: {to: 20000 rpm, time: 0.1 s}",
            ["20000 rpm is n d_m = 1.3e6 mm/min, above 1e6"],
        ),
        (
            "load: 1 N\nsampling: 200 Hz",
            ["BPFO (159 Hz) is above half of `sampling: 200 Hz`, so the record lacks it"],
        ),
    ],
)
def test_value_out_of_range_causes_one_warning(write: Write, text: str, parts: list[str]) -> None:
    lines = text.splitlines()
    base = "".join(
        f"{old}\n" for old in BASE.splitlines() if old.split(":")[0] not in {s.split(":")[0] for s in lines}
    )
    warnings = [note for note in load_study(write(f"{base}{text}\n")).assumptions if note.startswith("warning: ")]
    for part in parts:
        assert sum(part in note for note in warnings) == 1
    assert len(warnings) <= len(parts)
    assert all(len(note) <= 100 for note in warnings)


def test_warning_counts_the_cases_unless_it_concerns_all(write: Write) -> None:
    some = warnings_of(write, "sweep: {load: [1 kN, 70 kN, 95 kN]}\n")
    assert [note[note.rindex("(") :] for note in some] == ["(1 of 3 cases)", "(2 of 3 cases)"]
    assert not any("cases" in note for note in warnings_of(write, "sweep: {load: [90 kN, 95 kN]}\n"))


def test_highest_drawn_line_is_compared_with_the_passband(write: Write) -> None:
    drawn = "load: 1 N\nsampling: 400 Hz\nsweep: {clearance: [0 um, 5 um]}\nfigures: [{x: clearance, y: [Y]}]\n"
    assert warnings_of(write, drawn.replace("Y", "velocity@BPFO, velocity.rms")) == []
    (warning,) = warnings_of(write, drawn.replace("Y", "velocity@BPFO, velocity@2BPFO-healthy"))
    assert "2BPFO (318 Hz) is above half" in warning


def test_warnings_are_printed_and_stored(write: Write, tmp_path: Path) -> None:
    path = write(BASE + "load: 1 N\nsampling: 200 Hz\nmodel: static\n")
    assert type_("check", path)[0].count("above half of `sampling: 200 Hz`") == 1
    assert any("above half of" in note for note in json.loads(type_("check", path, "--json")[0])["notes"])
    assert "above half of `sampling: 200 Hz`" in str(store.provenance(load_study(path))["assumptions"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("speed: 1e9 rpm", "the inner race moves at 2.78e+06 m/s: its hoop stress rho v^2"),
        ("ramp: {to: 1e6 rpm, time: 1 s}\nmodel: planar", "ramp.to: at 1e+06 rpm the inner race moves"),
        ("duration: 1e9 s", "1e+13 samples: a record has at most 1e+09"),
        ("load: 1e31 N", "no plausible value is that large"),
        ("speed: 1e-40 rpm", "no plausible value is that small"),
        ("contact: {damping: {law: general, coefficient: 1, indentation_exponent: 1e9}}", "from 0 to 10"),
    ],
)
def test_unphysical_values_are_refused(write: Write, text: str, message: str) -> None:
    key = text.partition(":")[0]
    base = "".join(f"{line}\n" for line in f"{BASE}load: 1 N".splitlines() if not line.startswith(f"{key}:"))
    with pytest.raises(StudyError) as caught:
        load_study(write(f"{base}{text}\n"))
    (problem,) = caught.value.problems
    assert message in str(problem)


def test_speed_limit_is_below_the_burst_speed_of_steel(write: Write) -> None:
    """NF308 at 560 m/s on the inner race, where n d_m is 200 times its limit."""
    load_study(write(BASE.replace("1800 rpm", "200000 rpm") + "load: 1 N\n"))
    assert pytest.approx(104.72, rel=1e-4) == MAX_SPEED_FACTOR  # 1e6 mm/min in rad/s m


# Models that leave out what a case asks for

ITALICS: dict[str, dict[str, Any]] = {
    "damping": {"contact": {"damping": {"law": "kraemer", "beta": "2 us"}}},
    "the ring's acceleration": {"record": ["ring.acceleration"]},
    "inertia of the rollers": {"speed": "30000 rpm"},
    "tilt": {
        "defect": {"shape": "rectangular", "length": "3 mm", "width": "0.8 mm", "depth": "50 um", "offset": "2 mm"}
    },
}
"""What asks for each need of quality of the table in docs/abilities.md."""
ABILITY = {"the ring's acceleration": "acceleration", "inertia of the rollers": "roller inertia"}


def needs_of_quality() -> list[tuple[str, str, bool]]:
    """Requirement, model, and whether the model has it according to docs/abilities.md."""
    page = (Path(__file__).parents[2] / "docs/abilities.md").read_text(encoding="utf-8")
    head = next(line for line in page.splitlines() if line.startswith("| need | requested by |"))
    models = [cell.strip(" `") for cell in head.split("|")[3:-1]]
    rows = [line.replace("\\|", "/").split("|")[1:-1] for line in page.splitlines() if line.startswith("| *")]
    return [
        (row[0].strip(" *"), model, bool(cell.strip()))
        for row in rows
        for model, cell in zip(models, row[2:], strict=True)
    ]


def test_every_quality_requirement_has_a_scene() -> None:
    assert {need for need, _, _ in needs_of_quality()} == set(ITALICS)


@pytest.mark.parametrize(("need", "model", "has_it"), needs_of_quality())
def test_omitted_effects_are_named_in_a_warning(need: str, model: str, has_it: bool) -> None:
    if model == "impulse" and need == "tilt":
        pytest.skip("impulses have no place along the roller, and refuse it")
    warnings = list(omission_warnings([of_model(model, ITALICS[need])]))
    named = [text for text in warnings if f"omits {ABILITY.get(need, need)}:" in text]
    assert len(named) == (not has_it)
    assert all(text.startswith(f"warning: `{model}` omits") and len(text) <= 100 for text in warnings)


def of_model(model: str, fields: dict[str, Any]) -> Case:
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": model, "duration": "1 s"}
    slot = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "50 um"}
    return Case.model_validate(base | {"defect": slot} | fields)


def test_each_warning_gives_the_worst_value_and_the_count() -> None:
    cases = [of_model("ring", {"speed": f"{speed} rpm"}) for speed in (600, 6000, 9000)]
    (text,) = omission_warnings(cases)
    assert text.startswith("warning: `ring` (2 of 3) omits roller inertia: centrifugal force")
    assert text.endswith("; use `rollers`")
    assert len(text) <= 100


def test_reason_and_remedy_of_a_warning_are_those_of_the_same_case() -> None:
    fast = of_model("ring", {"speed": "9000 rpm"})
    tilting = fast.model_copy(update={"defects": (fast.defects[0].model_copy(update={"offset": 1e-3}),)})
    for cases, model in (([fast, tilting], "spatial"), ([tilting, fast], "rollers")):
        (text,) = (text for text in omission_warnings(cases) if "omits roller inertia" in text)
        assert text.endswith(f"; use `{model}`")
