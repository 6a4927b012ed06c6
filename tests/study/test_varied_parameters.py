"""Parameters of uncertainty: form of the surfaces, shaft, mass of the ring, edges."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bearingsim.study import StudyError, case_id, load_study
from tests.scenes.study_text import BASE, Write

pytestmark = pytest.mark.usefixtures("constant_candidates")

# Form of surfaces, shaft, mass of the ring, edges


def varied_cases(write: Write, text: str, more: str = "model: rollers\n") -> list[tuple[str, float, Any]]:
    """Kind, value and case of each variation of a study with one case."""
    study = load_study(write(f"{BASE}{more}uncertainty: {text}\n"))
    return [(variation.what, variation.value, variation.job.case) for variation in study.variations()]


def test_form_is_computed_in_three_samples_of_one_height(write: Write) -> None:
    """A of the spectrum is the height over 1.7; rollers keep their diameters, defects and all else stay."""
    rollers = "surfaces: {rollers: {diameter: {scatter: 0.5 um}}, seed: 9}\n"
    samples = varied_cases(write, "{form: 0.34 um}", f"model: rollers\n{rollers}")
    assert [(what, value) for what, value, _ in samples] == [("form", pytest.approx(0.34e-6))] * 3
    assert [case.surfaces.outer.spectrum.seed for _, _, case in samples] == [1, 2, 3]
    for _, _, case in samples:
        assert case.surfaces.outer.spectrum.amplitude == pytest.approx(0.2e-6)
        assert case.surfaces.inner == case.surfaces.outer
        assert case.surfaces.rollers.diameter.scatter == pytest.approx(0.5e-6)
        assert case.surfaces.seed == 9
    assert len({case_id(case) for _, _, case in samples}) == 3


def test_samples_of_form_keep_the_rollers_of_the_case(write: Write) -> None:
    """Their diameters and waviness, drawn by the case's seed; the races differ from sample to sample."""
    from bearingsim.assemble.form import build_form

    rollers = "{diameter: {scatter: 0.5 um}, spectrum: {amplitude: 50 nm}}"
    more = f"model: rollers\nsurfaces: {{rollers: {rollers}, seed: 9}}\n"
    forms = [build_form(case) for _, _, case in varied_cases(write, "{form: 0.34 um}", more)]
    assert all(np.array_equal(sample.rollers.table, forms[0].rollers.table) for sample in forms)
    assert np.ptp(forms[0].rollers.pieces[:, 0, :13].mean(axis=0)) == pytest.approx(0.25e-6, rel=1e-6)
    assert not np.allclose(forms[0].outer.table, forms[1].outer.table)


def test_height_of_the_form_is_peak_to_valley() -> None:
    from bearingsim.assemble.form import cubic_pieces, race_coefficients
    from bearingsim.config.sections.surfaces import RaceSurface
    from bearingsim.study.uncertainty import HEIGHT_RATIO

    surface = RaceSurface.model_validate({"spectrum": {"amplitude": "1 um"}})
    heights = [np.ptp(cubic_pieces(race_coefficients(surface, seed, 0), 4800)[:, 0]) for seed in range(40)]
    assert np.mean(heights) == pytest.approx(1e-6 * HEIGHT_RATIO, rel=0.03)


def test_other_parameters_change_one_value_each(write: Write) -> None:
    more = "model: planar\nshaft: {stiffness: 1e8 N/m, mass: 3 kg}\n"
    text = "{shaft: [2e7 N/m, 2e8 N/m], ring_mass: [1 kg, 4 kg], edge: [20 um, 80 um]}"
    cases = varied_cases(write, text, more)
    assert [case.shaft.stiffness for what, _, case in cases if what == "shaft"] == pytest.approx(
        [2e7, math.sqrt(40.0) * 1e7, 2e8]
    )
    assert [case.rig.ring_mass for what, _, case in cases if what == "ring_mass"] == pytest.approx([1.0, 2.0, 4.0])
    edges = [case.defects[0].edge.radius for what, _, case in cases if what == "edge"]
    assert edges == pytest.approx([20e-6, 40e-6, 80e-6])
    assert {case.shaft.mass for _, _, case in cases} == {3.0}


def test_impulses_depend_on_the_parameters_of_the_oscillator(write: Write) -> None:
    """Its stiffness, damping and mass, and the load of the rollers by the clearance; each changes the RMS."""
    from bearingsim import assemble

    text = "{damping: [1 us, 4 us], clearance: [0 um, 10 um], bracket: [0.5, 2], ring_mass: [1 kg, 4 kg]}"
    cases = varied_cases(write, text, "model: impulse\n")
    names = ["damping", "clearance", "bracket", "ring_mass"]
    assert [name for name, _, _ in cases] == [name for name in names for _ in range(3)]
    models = [assemble.model(case) for _, _, case in cases]
    damping = [model.C_x - case.rig.bracket_damping for model, (*_, case) in zip(models[:3], cases, strict=False)]
    assert damping == pytest.approx([0.5 * damping[1], damping[1], 2.0 * damping[1]], rel=1e-9)
    assert models[5].K_x < 0.8 * models[3].K_x
    assert models[8].K_x - models[6].K_x == pytest.approx(1.5 * cases[7][2].rig.bracket_stiffness, rel=1e-6)
    assert [model.m for model in models[9:]] == pytest.approx([1.0, 2.0, 4.0])


@pytest.mark.parametrize(
    ("text", "more", "caret", "message"),
    [
        ("{form: 0.3}", "", "0.3", "expected a length"),
        ("{form: 0 um}", "", "0 um", "expected a value above zero"),
        ("{form: 0.3 um}", "model: impulse\n", "0.3 um", "the impulse model has smooth surfaces"),
        (
            "{form: 0.3 um}",
            "surfaces: {inner: {spectrum: {amplitude: 1 um}}}\n",
            "0.3 um",
            "`surfaces` already gives the form of the races",
        ),
        ("{shaft: [1e8 N/m, 2e8 N/m]}", "", "[1e8", "the inner ring is rigidly supported"),
        ("{ring_mass: [1 kg, 2 kg]}", "model: static\n", "[1 kg", "the results of static do not depend on it"),
        ("{ring_mass: [1 kg, 2 kg]}", "rig: {ring: {bends: true}}\n", "[1 kg", "a flexible ring has its own mass"),
    ],
)
def test_what_cannot_act_is_refused(write: Write, text: str, more: str, caret: str, message: str) -> None:
    path = write(f"{BASE}{more}uncertainty: {text}\n")
    with pytest.raises(StudyError, match=message) as error:
        load_study(path)
    line, mark = str(error.value).splitlines()[1:3]
    assert line[mark.index("^") :].startswith(caret)


def test_edges_of_no_defect_are_refused(write: Write) -> None:
    text = "\n".join(line for line in BASE.splitlines() if not line.startswith("defect"))
    with pytest.raises(StudyError, match="a case has no defect with edges"):
        load_study(write(f"{text}\nuncertainty: {{edge: [20 um, 80 um]}}\n"))


def test_edges_of_a_scan_are_refused(write: Write) -> None:
    scan = Path(__file__).parents[2] / "studies/scans/spall.csv"
    text = re.sub("defect: .*", f"defect: {{shape: scan, file: {scan}}}", BASE)
    with pytest.raises(StudyError, match="a scan already contains its edges"):
        load_study(write(f"{text}uncertainty: {{edge: [20 um, 80 um]}}\n"))


def test_a_missing_bracket_is_not_varied(write: Write) -> None:
    assert (
        varied_cases(write, "{bracket: [0.5, 2]}", "rig: {bracket_stiffness: 0 N/m, ring: {bends: true}}\n") == []
    )
