"""Features of frequency bands, requested by figures, by an accuracy or by `features`."""

from pathlib import Path

import pytest

from bearingsim import store
from bearingsim.config import Case
from bearingsim.simulation import time_grid
from bearingsim.study import StudyError, case_id, load_study
from tests.conftest import Write
from tests.scenes.commands import type_

BASE = """\
study: a
bearing: nf308
speed: 1800 rpm
model: static
duration: 0.2 s
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}
sweep: {load: [150 N, 300 N]}
"""
ALL = {RMS := "velocity.rms@10-1000Hz", HIGH := "acceleration.rms@1000-20000Hz", ENVELOPE := "envelope@BPFO"}


def features(write: Write, text: str) -> set[str]:
    (test_case,) = {case.features for case in load_study(write(BASE + text)).cases()}
    return set(test_case)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", set()),
        (f"features: [{HIGH}]\n", {HIGH}),
        (f"figures: [{{y: {RMS}, x: load}}]\n", {RMS}),
        (
            f"figures: [{{y: [{RMS}-healthy, {ENVELOPE}], x: load}}]\nfeatures: [{HIGH}, {RMS}]\n",
            {RMS, ENVELOPE, HIGH},
        ),
    ],
)
def test_features_of_figures_are_computed(write: Write, text: str, named: set[str]) -> None:
    assert features(write, text) == named


def test_features_of_figures_are_computed_with_overrides(write: Write) -> None:
    path = write(f"{BASE}figures: [{{y: {RMS}, x: load}}]\nquick: {{features: [{HIGH}]}}\n")
    (plain,) = {case.features for case in load_study(path, {"features": f"[{ENVELOPE}]"}).cases()}
    (quick,) = {case.features for case in load_study(path, quick=True).cases()}
    assert set(plain) == {RMS, ENVELOPE}
    assert set(quick) == {RMS, HIGH}


def test_features_of_an_accuracy_are_computed(write: Write) -> None:
    text = BASE.replace("model: static\n", "") + f"accuracy: {{within: 5 %, of: [{RMS}-healthy, {ENVELOPE}]}}\n"
    study = load_study(write(text))
    assert {case.features for case in study.cases()} == {(RMS, ENVELOPE)}


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("velocity.rms@1000-10Hz", "the band is empty"),
        ("velocity.rms@10-200000Hz", "not valid above 100 kHz"),
        ("velocity.rms@5-1000Hz", "a record of 0.2 s does not resolve 5 Hz"),
        ("velocity.rms@1000-1005Hz", "does not resolve 5 Hz"),
        ("velocity.rms@0-5Hz", "does not resolve 5 Hz"),
    ],
)
def test_unresolved_band_is_refused_at_its_position(write: Write, name: str, reason: str) -> None:
    with pytest.raises(StudyError, match=reason) as caught:
        load_study(write(f"{BASE}figures: [{{y: {name}, x: load}}]\n"))
    line, caret = str(caught.value).splitlines()[1:3]
    assert line[caret.index("^") :].startswith(name)


def test_misspelled_band_is_answered_with_examples(write: Write) -> None:
    with pytest.raises(StudyError, match=r"bands are named as in velocity\.rms@10-1000Hz"):
        load_study(write(f"{BASE}figures: [{{y: velocity.rms@1-5kHz, x: load}}]\n"))


def test_default_features_need_no_request(write: Write) -> None:
    with pytest.raises(StudyError, match="is computed for every case"):
        load_study(write(f"{BASE}features: [velocity.rms]\n"))


def test_order_of_features_does_not_change_the_id() -> None:
    forward, reverse, none = (
        Case.model_validate({"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "features": names})
        for names in ([RMS, ENVELOPE], [ENVELOPE, RMS], [])
    )
    assert case_id(forward) == case_id(reverse) != case_id(none)


def test_a_high_band_raises_the_rate_of_fine_samples() -> None:
    plain, high = (
        Case.model_validate(
            {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "ring", "features": names}
        )
        for names in ([], [HIGH])
    )
    assert time_grid.make_grid(plain).fine_rate < 20e3 / 0.15 < time_grid.make_grid(high).fine_rate


def test_bands_are_stored_and_drawn_with_the_healthy_value(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(f"{BASE}figures: [{{y: [{RMS}, {RMS}-healthy], x: load}}]\nfeatures: [{ENVELOPE}]\n")
    type_("run", path, "--jobs", "1", "--out", tmp_path / "out")
    results = store.open_results(tmp_path / "out")
    table = results.table().set_index("job")
    for job, healthy in table["healthy"][table["healthy"] != ""].items():
        for name in (RMS, ENVELOPE):
            apart = table.loc[job, name] - table.loc[healthy, name]  # type: ignore[index]
            assert table.loc[job, f"{name}-healthy"] == apart  # type: ignore[index]
            assert apart > 0.0
    output, _ = type_("show", tmp_path / "out")
    assert ".rms@10-1000Hz" in output  # below "velocity" in a stacked heading
    for kind in ("sweep", "pit"):  # the latter makes the case again from its parameters
        type_("plot", tmp_path / "out", "--kind", kind, "--format", "svg")
