"""Roundness profiles: reading, repairs with notes, harmonics, refusals at their place in the study."""

from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bearingsim.assemble.form import INNER_STREAM, OUTER_STREAM, race_coefficients
from bearingsim.config import Case
from bearingsim.config.scan.file import ScanError
from bearingsim.config.scan.notes import notes
from bearingsim.config.scan.roundness import form_harmonics, read_roundness
from bearingsim.study import load_study
from bearingsim.study.jobs import case_id
from bearingsim.study.used import relevant_fields
from bearingsim.text.yamlfile import StudyError

pytestmark = pytest.mark.usefixtures("constant_candidates")

HEAD = "angle [deg],deviation [um]"
ORDERS = {2: (0.3, 0.4), 5: (0.1, -2.0), 12: (0.05, 1.0), 40: (0.01, 3.0)}
"""Amplitude (um) and phase of each order."""
EVEN = np.arange(0.0, 360.0, 0.5)
ECCENTRIC = 3.0 * np.cos(np.radians(EVEN - 40.0)) + 1.0


def heights(angles: Any, orders: Any = ORDERS) -> np.ndarray:
    """Deviation (um) at angles (deg)."""
    return np.sum([A * np.cos(n * np.radians(angles) - phase) for n, (A, phase) in orders.items()], axis=0)


def write(path: Path, angles: Any, values: Any, head: str = HEAD) -> Path:
    lines = [f"{angle:.9g},{value:.9g}" for angle, value in zip(angles, values, strict=True)]
    path.write_text("\n".join(["# by a roundness tester", head, *lines, ""]).replace("nan", ""))
    return path


def amplitudes(path: Path, on_outer: bool = True) -> np.ndarray:
    return 1e6 * form_harmonics(read_roundness(path), (2, 50), on_outer)


EXPECTED = np.array([A * np.exp(-1j * phase) for n in range(51) for A, phase in [ORDERS.get(n, (0.0, 0.0))]])


def test_harmonics_of_an_even_profile_are_exact_without_the_least_squares_circle(tmp_path: Path) -> None:
    values = amplitudes(write(tmp_path / "a.csv", EVEN, heights(EVEN) + ECCENTRIC))
    np.testing.assert_allclose(values, EXPECTED, atol=2e-9)


@pytest.mark.parametrize(
    ("angles", "tolerance"),
    [
        (EVEN + 7.3, 1e-8),  # does not begin at zero
        (EVEN - 180.0, 1e-8),
        (np.linspace(0.0, 360.0, 721), 1e-8),  # both ends are given
        (EVEN[::-1], 1e-8),
        (np.random.default_rng(1).permutation(EVEN), 1e-8),
        (np.delete(EVEN, [100, 101, 300]), 2e-4),
        (np.sort(EVEN + np.random.default_rng(2).uniform(-0.2, 0.2, 720)) % 360.0, 2e-4),
    ],
)
def test_harmonics_do_not_depend_on_the_points(tmp_path: Path, angles: np.ndarray, tolerance: float) -> None:
    np.testing.assert_allclose(
        amplitudes(write(tmp_path / "a.csv", angles, heights(angles))), EXPECTED, atol=tolerance
    )


def test_a_larger_radius_is_less_material_on_the_outer_race_only(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", np.radians(EVEN), 40.0 + 1e-3 * heights(EVEN), "angle [rad],radius [mm]")
    np.testing.assert_allclose(amplitudes(path, on_outer=True), -EXPECTED, atol=1e-4)
    np.testing.assert_allclose(amplitudes(path, on_outer=False), EXPECTED, atol=1e-4)


def test_the_waviness_of_a_case_is_that_of_its_profile(tmp_path: Path) -> None:
    """A profile acts as the harmonics that it contains, turned by its angle, and adds to others."""
    file = str(write(tmp_path / "a.csv", EVEN, heights(EVEN) + ECCENTRIC))
    given: list[dict[str, Any]] = [
        {"order": n, "amplitude": f"{A} um", "phase": f"{phase + n * radians(10.0):.12f} rad"}
        for n, (A, phase) in ORDERS.items()
        if abs(phase + n * radians(10.0)) < 6.28
    ]
    orders = [entry["order"] for entry in given]
    assert orders == [2, 5, 12]
    for race, stream in (("outer", OUTER_STREAM), ("inner", INNER_STREAM)):
        measured = case(**{race: {"roundness": {"file": file, "angle": "10 deg"}}}).surfaces
        written = case(**{race: {"harmonics": given}}).surfaces
        both = case(**{race: {"harmonics": given, "roundness": {"file": file, "angle": "10 deg"}}}).surfaces
        of_measured, of_written, of_both = (
            race_coefficients(getattr(surfaces, race), 0, stream) for surfaces in (measured, written, both)
        )
        np.testing.assert_allclose(of_measured[orders], of_written[orders], atol=1e-14)
        np.testing.assert_allclose(of_both[orders], 2.0 * of_written[orders], atol=1e-14)


def case(**surfaces: Any) -> Case:
    return Case.model_validate({"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "surfaces": surfaces})


def test_ids_depend_on_the_content_not_on_the_place(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    first, moved = (write(tmp_path / name, EVEN, heights(EVEN)) for name in ("a.csv", "there/b.csv"))
    changed = write(tmp_path / "c.csv", EVEN, 1.001 * heights(EVEN))
    ids = [case_id(case(outer={"roundness": str(file)})) for file in (first, moved, changed)]
    assert ids[0] == ids[1] != ids[2]
    assert case_id(case(outer={"roundness": {"file": str(first), "orders": ["2", "40"]}})) != ids[0]
    assert case_id(case(inner={"roundness": str(first)})) != ids[0]
    assert case(outer={"roundness": "none"}).surfaces is None


def test_ids_of_form_without_a_profile_are_those_of_before() -> None:
    """A key that is not given is no part of the id."""
    text = relevant_fields(case(outer={"spectrum": {"amplitude": "0.2 um"}}))["surfaces"]
    spectrum = '{"amplitude":2e-07,"exponent":1.3,"orders":[2,200]}'
    assert text == f'{{"inner":null,"outer":{{"harmonics":[],"spectrum":{spectrum}}},"rollers":null,"seed":0}}'
    assert "surfaces" not in relevant_fields(case())


def spiky(*indices: int) -> np.ndarray:
    values = heights(EVEN)
    values[list(indices)] += 5.0
    return values


def with_missing(*indices: int) -> np.ndarray:
    values = heights(EVEN)
    values[list(indices)] = np.nan
    return values


TURN = np.append(EVEN, 360.0)
REPAIRED = {
    "two missing values": ((EVEN, with_missing(7, 21)), "2 missing values removed: 3.5 deg, 10.5 deg"),
    "a spike": ((EVEN, spiky(60)), "1 spike of 4.99 um or more removed: 30 deg"),
    "descending angles": ((EVEN[::-1], heights(EVEN[::-1])), "the angles are not ascending and were sorted"),
    "ends that differ": (
        (TURN, heights(TURN) + 0.02 * TURN / 360.0),
        "the values at both ends of the revolution differ by 0.02 um; their mean is used",
    ),
}


@pytest.mark.parametrize("what", REPAIRED)
def test_repairs_are_reported_and_leave_the_form(tmp_path: Path, what: str) -> None:
    (angles, values), note = REPAIRED[what]
    path = write(tmp_path / "a.csv", angles, values)
    remarks = notes([case(outer={"roundness": str(path)})])
    assert f"a.csv: {note}" in remarks
    np.testing.assert_allclose(amplitudes(path), EXPECTED, atol=5e-3)


def test_a_rounded_end_of_the_turn_is_its_end(tmp_path: Path) -> None:
    """2 pi printed with four decimals is 6.2832, which is 1.5e-5 more."""
    angles = np.radians(TURN)
    lines = [f"{angle:.4f},{value:.9g}" for angle, value in zip(angles, heights(TURN), strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["angle [rad],deviation [um]", *lines]))
    np.testing.assert_allclose(amplitudes(tmp_path / "a.csv"), EXPECTED, atol=5e-3)


def test_both_ends_of_a_turn_below_a_revolution_are_averaged(tmp_path: Path) -> None:
    """2 pi printed with three decimals is 6.283, 1.9e-4 less; a spline from end to end would overshoot."""
    angles = np.linspace(0.0, 2.0 * np.pi, 73)
    values = np.cos(5.0 * angles)
    values[-1] += 0.05
    lines = [f"{angle:.3f},{value:.9g}" for angle, value in zip(angles, values, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["angle [rad],deviation [um]", *lines]))
    expected = np.fft.rfft([1.025, *values[1:-1]]) / 36.0
    found = 1e6 * form_harmonics(read_roundness(tmp_path / "a.csv"), (2, 9), True)
    np.testing.assert_allclose(found[2:], expected[2:10], atol=5e-3)


def test_what_is_taken_is_reported(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", EVEN, heights(EVEN) + ECCENTRIC)
    (remark,) = notes([case(outer={"roundness": str(path)}, inner={"roundness": str(path)})])
    assert remark == "a.csv: orders 2 to 50: 0.824 um from peak to valley; an eccentricity of 3 um is removed"


WRONG_FILES = {
    "no head": (
        "0,1\n1,2\n",
        "expected columns `angle` and either `deviation` or `radius`, got `0`, `1` (the first",
    ),
    "both columns": ("angle [deg],deviation [um],radius [mm]\n0,1,1\n", "either `deviation` or `radius`"),
    "no unit of an angle": ("angle,deviation [um]\n0,1\n", "the unit of `angle` is missing (write `angle [deg]`"),
    "no unit of a length": ("angle [deg],deviation\n0,1\n", "the unit of `deviation` is missing (write `dev"),
    "another unit": ("angle [deg],deviation [deg]\n0,1\n", "`deviation [deg]` has no unit of length"),
    "an unknown unit": ("angle [grad],deviation [um]\n0,1\n", "`angle [grad]` has no unit of angle"),
    "semicolons": (f"{HEAD}\n".replace(",", ";") + "0;1\n", "the separator is `;` (use a comma, and a point"),
    "decimal commas": (f"{HEAD}\n0,0,1,5\n", "line 2: 4 cells, the first line has 2 (cells end with a comma"),
    "a quoted decimal comma": (f'{HEAD}\n0,"0,15"\n', "expected a number, got `0,15` (use a point for decimals)"),
    "words": (f"{HEAD}\n0,high\n", "line 2: expected a number, got `high`"),
    "infinity": (f"{HEAD}\n0,inf\n", "line 2: `inf` is not finite"),
    "a point without angle": (f"{HEAD}\n0,1\n,2\n", "line 3: a point has no angle"),
    "two profiles": ("angle [deg],deviation [um],deviation [um]\n0,1,2\n", "two columns are named `deviation`"),
    "nothing": ("", "no points in this file"),
    "a head alone": (f"{HEAD}\n", "no points in this file"),
    "few points": (f"{HEAD}\n" + "".join(f"{30 * n},{n % 2}\n" for n in range(12)), "12 points: at least 14"),
}


@pytest.mark.parametrize("what", WRONG_FILES)
def test_files_of_another_format_are_refused(tmp_path: Path, what: str) -> None:
    content, message = WRONG_FILES[what]
    (tmp_path / "a.csv").write_text(content)
    assert message in refusal(tmp_path / "a.csv")


def refusal(path: Path) -> str:
    with pytest.raises(ScanError) as caught:
        read_roundness(path)
    return str(caught.value)


UNUSABLE = {
    "two turns": (
        np.arange(0.0, 720.0, 0.5),
        heights(np.arange(0.0, 720.0, 0.5)),
        "the angles cover 719.5 deg; a",
    ),
    "an angle twice": (np.append(EVEN, 30.0), np.append(heights(EVEN), 0.0), "two points have the angle 30 deg"),
    "a circle": (EVEN, np.full(720, 0.25), "all values are the same (0.25 um)"),
    "a drift": (EVEN, heights(EVEN) + EVEN / 360.0, "does not close: it differs by 0.996 um between 0 and 359.5"),
    "a drift with both ends": (TURN, heights(TURN) + TURN / 360.0, "does not close: it differs by 1 um between 0"),
    "many missing values": (EVEN, with_missing(*range(0, 400, 10)), "40 of 720 values are missing (0 deg, 5 deg"),
    "many spikes": (EVEN, spiky(*range(0, 200, 20)), "10 spikes of "),
}


@pytest.mark.parametrize("what", UNUSABLE)
def test_unusable_profiles_are_refused(tmp_path: Path, what: str) -> None:
    angles, values, message = UNUSABLE[what]
    assert message in refusal(write(tmp_path / "a.csv", angles, values))


def test_other_files_are_refused(tmp_path: Path) -> None:
    assert "no file" in refusal(tmp_path / "none.csv")
    (tmp_path / "a.xlsx").touch()
    assert "expected a file that ends in .csv or .txt, got `a.xlsx`" in refusal(tmp_path / "a.xlsx")
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00")
    assert "not a text file in UTF-8" in refusal(tmp_path / "b.csv")
    (tmp_path / "folder.csv").mkdir()
    assert "folder.csv` is a folder" in refusal(tmp_path / "folder.csv")


STUDY = """\
study: small
bearing: nf308
speed: 1800 rpm
load: 150 N
surfaces: {{outer: {{roundness: {}}}}}
"""
COARSE = np.arange(0.0, 360.0, 3.6)
GAPPED = np.concatenate([EVEN[:100], EVEN[120:]])
IN_A_STUDY = {
    "no file": ("none.csv", "none.csv", "surfaces.outer.roundness.file: no file `none.csv` (a path is relative"),
    "a number": ("{file: 3 um}", "3 um", "no file `3 um`"),
    "no file's name": ("{orders: [2, 50]}", "roundness", "`file` is missing"),
    "a list": ("[race.csv]", "[race.csv]", "surfaces.outer.roundness: expected a mapping of keys"),
    "order 1": ("{file: race.csv, orders: [1, 50]}", "[1, 50]", "order 1 of a measured profile is the position"),
    "orders the wrong way": ("{file: race.csv, orders: [50, 2]}", "[50, 2]", "50, is above the highest, 2"),
    "a single order": (
        "{file: race.csv, orders: 50}",
        "50",
        "expected the lowest and the highest order, got `50`",
    ),
    "beyond the points": (
        "{file: race.csv, orders: [2, 200]}",
        "[2, 200]",
        "720 points are too few for order 200, which needs 1400 (7 per undulation) (`orders: [2, 102]`, or more"
        " points)",
    ),
    "few points for the default": ("coarse.csv", "coarse.csv", "100 points are too few for order 50"),
    "a gap": (
        "gapped.csv",
        "gapped.csv",
        "a gap of 10.5 deg from 49.5 deg is over half an undulation of order 50 (`orders: [2, 17]`, or measure a"
        " full revolution)",
    ),
    "an unknown key": ("{file: race.csv, order: 3}", "order", "surfaces.outer.roundness: unknown key `order`"),
    "millimetres": (
        "millimetres.csv",
        "millimetres.csv",
        "823.677 um is over 1 % of the rolling element's diameter (is the unit right?)",
    ),
}


@pytest.mark.parametrize("what", IN_A_STUDY)
def test_a_study_is_refused_at_the_profile(tmp_path: Path, monkeypatch: Any, what: str) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "race.csv", EVEN, heights(EVEN))
    write(tmp_path / "coarse.csv", COARSE, heights(COARSE))
    write(tmp_path / "gapped.csv", GAPPED, heights(GAPPED))
    write(tmp_path / "millimetres.csv", EVEN, heights(EVEN), "angle [deg],deviation [mm]")
    value, caret, message = IN_A_STUDY[what]
    (tmp_path / "study.yaml").write_text(STUDY.format(value))
    with pytest.raises(StudyError) as caught:
        load_study("study.yaml")
    (problem,) = caught.value.problems
    text, source, mark = str(problem).splitlines()[:3]
    assert message in text
    assert source[mark.index("^") :].startswith(caret)


def test_profiles_can_be_swept(tmp_path: Path) -> None:
    """A profile is found beside its study, and files, orders and angles can be swept."""
    for name, scale in (("a.csv", 1.0), ("b.csv", 0.5)):
        write(tmp_path / name, EVEN, scale * heights(EVEN))
    text = STUDY.format("a.csv") + (
        "sweep:\n  surfaces.outer.roundness.file: [a.csv, b.csv]\n"
        "  surfaces.outer.roundness.angle: [0 deg, 5 deg]\n"
    )
    (tmp_path / "study.yaml").write_text(text)
    cases = load_study(tmp_path / "study.yaml").cases()
    assert len({case_id(case) for case in cases}) == 4
    assert len({case.surfaces.outer.roundness.digest for case in cases}) == 2
    text = STUDY.format("a.csv") + "sweep: {surfaces.outer.roundness: [a.csv, b.csv, none]}\n"
    (tmp_path / "study.yaml").write_text(text)
    assert [case.surfaces is None for case in load_study(tmp_path / "study.yaml").cases()] == [False, False, True]
