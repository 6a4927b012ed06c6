"""Reduced grid of `quick`, and overrides of the command line."""

import pytest

from bearingsim.cli.options import parse_assignments
from bearingsim.study import StudyError, load_study
from tests.scenes.study_text import BASE, Write, swept

SWEPT = BASE + (
    "sweep: {load: [1 N, 2 N, 3 N], zip: {defect.width: [1 mm, 2 mm], defect.depth: [1 um, 2 um]}}\n"
    "figures: [{y: velocity@BPFO, x: load, by: defect.width}]\n"
    "quick: {duration: 0.3 s, sweep: {load: [2 N], zip: {defect.width: [3 mm, 4 mm], clearance: [0 um, 1 um]}}}\n"
)


def test_quick_takes_the_reduced_grid(write: Write) -> None:
    path = write(SWEPT)
    assert len(load_study(path).cases()) == 6
    study = load_study(path, quick=True)
    assert study.quick
    assert swept(study) == [(2.0, 0.003, 0.0), (2.0, 0.004, 1e-6)]
    assert {case.duration for case in study.cases()} == {0.3}
    assert {case.defects[0].depth for case in study.cases()} == {5e-5}


@pytest.mark.parametrize(
    ("overrides", "loads", "widths"),
    [
        ({"load": "7 N"}, {7.0}, {0.001, 0.002}),
        ({"load": "[7 N, 8 N]"}, {7.0, 8.0}, {0.001, 0.002}),
        ({"load": "{linspace: [7 N, 9 N, 3]}"}, {7.0, 8.0, 9.0}, {0.001, 0.002}),
        ({"defect.width": "5 mm"}, {1.0, 2.0, 3.0}, {0.005}),
        ({"defect.width": "5 mm", "load": "7 N"}, {7.0}, {0.005}),
    ],
)
def test_an_override_replaces_a_sweep(
    write: Write, overrides: dict[str, str], loads: set[float], widths: set[float]
) -> None:
    study = load_study(write(SWEPT), overrides)
    assert {case.load for case in study.cases()} == loads
    assert {case.defects[0].width for case in study.cases()} == widths
    assert {case.defects[0].depth for case in study.cases()} == {1e-6, 2e-6}
    assert all({"load", "defect.width"} <= job.swept.keys() for job in study.jobs() if job.healthy)
    assert study.overrides == overrides


def test_override_preserves_position_of_its_axis(write: Write) -> None:
    study = load_study(write(SWEPT), {"load": "[7 N, 8 N]"})
    assert list(study.units) == ["load", "defect.width", "defect.depth"]
    assert [row[0] for row in swept(study)] == [7.0, 7.0, 8.0, 8.0]


def test_override_of_unswept_parameter(write: Write) -> None:
    overrides = {
        "duration": "2 s",
        "record": "[ring.velocity, roller.outer_force]",
        "bearing.roller_length": "9 mm",
    }
    study = load_study(write(SWEPT), overrides)
    case = study.cases()[0]
    assert (case.duration, len(case.record), case.bearing.roller_length) == (2.0, 2, 0.009)
    assert "duration" not in study.jobs()[0].swept
    assert len(load_study(write(SWEPT), {"speed": "[20 Hz, 30 Hz]"}).cases()) == 12


@pytest.mark.parametrize("path", ["surfaces.outer.spectrum.orders", "surfaces.inner.spectrum.orders"])
def test_override_of_a_list(write: Write, path: str) -> None:
    surfaces = "surfaces: {outer: {spectrum: {amplitude: 1 um}}, inner: {spectrum: {amplitude: 1 um}}}\n"
    for text, orders in (("[2, 50]", [(2, 50)]), ("[[2, 50], [3, 60]]", [(2, 50), (3, 60)])):
        cases = load_study(write(BASE + surfaces), {path: text}).cases()
        races = [getattr(case.surfaces, path.split(".")[1]) for case in cases]
        assert [race.spectrum.orders for race in races] == orders


DEFECTS = [f"{{shape: {shape}, length: 3 mm, width: 1 mm, depth: 1 um}}" for shape in ("circular", "triangular")]


@pytest.mark.parametrize(
    ("sweep", "path", "text", "value"),
    [
        (f"defect: [{', '.join(DEFECTS)}]", "defect.width", "0.4 mm", 0.4e-3),
        (f"defect: [{', '.join(DEFECTS)}]", "defects.1.width", "0.4 mm", 0.4e-3),
        (f"zip: {{defect: [{', '.join(DEFECTS)}], load: [1 N, 2 N]}}", "defect.width", "0.4 mm", 0.4e-3),
        ("bearing: [nf308, nu204]", "bearing.roller_length", "10 mm", 10e-3),
        ("contact.damping: [kraemer]", "contact.damping.beta", "5 us", 5e-6),
        ("contact: [{stiffness: johnson}, {stiffness: iso16281}]", "contact.damping.beta", "5 us", 5e-6),
    ],
)
def test_an_override_replaces_a_value_in_swept_sections(
    write: Write, sweep: str, path: str, text: str, value: float
) -> None:
    base = BASE + f"sweep: {{{sweep}}}\n"
    for study in (
        load_study(write(base), {path: text}),
        load_study(write(f"{base}quick: {{{path}: {text}}}\n"), quick=True),
    ):
        assert len(study.cases()) == len(load_study(write(base)).cases())
        values = {
            {
                "width": case.defects[0].width,
                "roller_length": case.bearing.roller_length,
                "beta": case.contact.damping.model_dump()["beta"],
            }[path.rpartition(".")[2]]
            for case in study.cases()
        }
        assert values == {value}


@pytest.mark.parametrize(
    "entries", [("defect.width: 0.5 mm", "defect: %s"), ("defect: %s", "defect.width: 0.5 mm")]
)
def test_order_of_keys_in_quick_has_no_effect(write: Write, entries: tuple[str, str]) -> None:
    defect = "{shape: rectangular, length: 1 mm, width: 0.8 mm, depth: 2 um}"
    text = BASE + f"quick: {{{', '.join(entries) % defect}}}\n"
    (case,) = load_study(write(text), quick=True).cases()
    assert (case.defects[0].width, case.defects[0].length) == (0.0005, 0.001)


@pytest.mark.parametrize(
    ("entries", "path"),
    [
        ("load: 3 N, sweep: {load: [1 N, 2 N]}", "load"),
        ("sweep: {load: [1 N, 2 N]}, load: 3 N", "load"),
        ("defect.width: 1 mm, defects.1.width: 2 mm", "defects.1.width"),
        ("sweep: {load: [1 N], zip: {load: [2 N], settle: [1 s]}}", "load"),
        ("seed: 3, sweep: {repeat: 2}", "seed"),
    ],
)
def test_path_given_twice_in_quick_is_refused(write: Write, entries: str, path: str) -> None:
    with pytest.raises(StudyError, match=f"quick: `{path}` is given twice"):
        load_study(write(BASE + f"quick: {{{entries}}}\n"), quick=True)


def test_quick_sweep_in_another_spelling_keeps_the_path_of_figures(write: Write) -> None:
    text = "sweep: {defect.width: [1 mm, 2 mm]}\nquick: {sweep: {defects.1.width: [1 mm, 3 mm]}}\n"
    study = load_study(write(BASE + text), quick=True)
    assert list(study.units) == ["defect.width"]
    assert swept(study) == [(0.001,), (0.003,)]


@pytest.mark.parametrize(
    ("overrides", "quick", "count", "noted"),
    [
        ({"load": "[1 N, 2 N]"}, "", 4, True),
        ({}, "quick: {sweep: {load: [1 N, 2 N]}}\n", 4, True),
        ({"load": "[1 N]"}, "", 2, False),  # a single value leaves nothing to combine
        ({"load": "1 N"}, "", 2, False),
        ({"settle": "[1 ms, 2 ms]"}, "", 4, False),
    ],
)
def test_path_taken_out_of_a_zip_is_noted(
    write: Write, overrides: dict[str, str], quick: str, count: int, noted: bool
) -> None:
    text = BASE + "sweep: {zip: {load: [150 N, 300 N], speed: [900 rpm, 1800 rpm]}}\n" + quick
    study = load_study(write(text), overrides, quick=bool(quick))
    note = "`load` no longer varies together with `speed`: all combinations are computed"
    assert (len(study.cases()), note in study.notes) == (count, noted)


def test_repeated_assignment_takes_its_last_place(write: Write) -> None:
    """The section replaces the first width, and the last width that of the section."""
    slot = "{shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 5 um}"
    first, last = "defect.width=1 mm", "defect.width=2 mm"
    assert parse_assignments([first, f"defect={slot}", last]) == {"defect": slot, "defect.width": "2 mm"}
    (case,) = load_study(write(BASE), parse_assignments([first, f"defect={slot}", last])).cases()
    assert case.defects[0].width == 2e-3
    (case,) = load_study(write(BASE), parse_assignments([last, f"defect={slot}"])).cases()
    assert case.defects[0].width == 0.8e-3
