# ruff: noqa: E501 (a table of messages, one line each)
"""`accuracy:` in a study: its meaning, and refusals with their positions."""

from pathlib import Path

import pytest

from bearingsim.study import Problem, StudyError, load_study
from bearingsim.study.goal import Goal
from bearingsim.study.uncertainty import NO_OIL, NO_SLIP, TRIED_FRICTION
from tests.scenes.study_text import BASE, Write

FIGURE = "figures: [{y: [velocity@BPFO, seconds, velocity.rms], x: load}, {y: velocity@BPFO, x: load}]\n"
SWEEP = "sweep: {load: [150 N, 300 N]}\n"
MODELS = "accuracy: 2 %\n" + SWEEP + FIGURE


def goal(write: Write, text: str) -> Goal | None:
    return load_study(write(BASE + text)).goal


def problems(path: Path, overrides: dict[str, str] | None = None) -> list[Problem]:
    with pytest.raises(StudyError) as caught:
        load_study(path, overrides)
    return caught.value.problems


def text_at_caret(problem: Problem) -> str:
    """The text at the caret."""
    lines = str(problem).splitlines()
    return lines[1][lines[2].index("^") :]


@pytest.mark.parametrize(
    ("text", "within", "of"),
    [
        ("2 %", 0.02, ("velocity@BPFO", "velocity.rms")),  # what figures draw, and an accuracy can be held of
        ("0.5 %", 0.005, ("velocity@BPFO", "velocity.rms")),
        ("50 %", 0.5, ("velocity@BPFO", "velocity.rms")),
        ("{within: 5 %}", 0.05, ("velocity@BPFO", "velocity.rms")),
        ("{within: 5 %, of: outer_force.max}", 0.05, ("outer_force.max",)),
        ("{within: 5 %, of: [acceleration@BPFI-healthy, displacement.rms, displacement.rms]}", 0.05,
         ("acceleration@BPFI-healthy", "displacement.rms")),
    ],
)  # fmt: skip
def test_accuracy_has_a_bound_and_features(write: Write, text: str, within: float, of: tuple[str, ...]) -> None:
    assert goal(write, f"accuracy: {text}\n{SWEEP}{FIGURE}") == Goal(within, of)


def test_study_without_accuracy_has_no_goal(write: Write) -> None:
    study = load_study(write(BASE))
    assert study.goal is None
    assert [case.model for case in study.cases_with({"model": "ring"}) if case] == ["ring"] * len(study.cases())


def test_cases_have_the_reference_model(write: Write) -> None:
    study = load_study(write(BASE + MODELS))
    assert [case.model for case in study.cases()] == ["planar", "planar"]
    lower = study.cases_with({"model": "static"})
    named = load_study(write(BASE + MODELS.replace("accuracy: 2 %", "model: static\nrecord: []\nuntil: 0.5 %")))
    assert lower == named.cases()
    assert study.cases_with({"excitation": "nonsense"}) == [None, None]
    fixed = [case.load if case else None for case in study.cases_with({"load": "100 N"})]
    assert fixed == [100.0, 100.0]  # though it is swept


@pytest.mark.parametrize(
    ("text", "caret", "message"),
    [
        ("0.4 %", "0.4 %", "accuracy: expected 0.5 % to 50 %, got `0.4 %` (the reference itself is not more accurate than that (docs/accuracy.md))"),
        ("60 %", "60 %", "accuracy: expected 0.5 % to 50 %, got `60 %`"),
        ("-2 %", "-2 %", "accuracy: expected 0.5 % to 50 %, got `-2 %` (the reference itself is not more accurate than that (docs/accuracy.md))"),
        ("2 mm", "2 mm", None),
        ("close", "close", None),
        ("[2 %]", "[2 %]", None),
        ("{within: close}", "close}", None),
        ("{of: [velocity.rms]}", "accuracy", "accuracy: `within` is missing (as in `{within: 2 %}`)"),
        ("{within: 2 %, off: [velocity.rms]}", "off", "accuracy: unknown key `off` (did you mean `of`?)"),
        ("{within: 2 %, for: [velocity.rms]}", "for", None),
        ("{within: 2 %, of: [velocity@BPF0]}", "velocity@BPF0", "accuracy.of: accuracy is not defined for `velocity@BPF0` (did you mean `velocity@BPFO`?)"),
        ("{within: 2 %, of: [velocity@BPFO.phase]}", "velocity@BPFO.phase", None),
        ("{within: 2 %, of: seconds}", "seconds", "accuracy.of: accuracy is not defined for `seconds` (lines such as `velocity@BPFO`, an RMS such as `velocity.rms`, `outer_force.max`)"),
        ("{within: 2 %, of: []}", "[]", None),
        ("0.5", "0.5", "accuracy: expected a percentage such as `1 %`, got `0.5` (the unit is missing) (as in `accuracy: 2 %`)"),
    ],
)  # fmt: skip
def test_invalid_accuracy_is_reported_at_its_position(
    write: Write, text: str, caret: str, message: str | None
) -> None:
    all_problems = problems(write(f"{BASE}accuracy: {text}\n{SWEEP}{FIGURE}"))
    assert len(all_problems) == 1, all_problems
    assert text_at_caret(all_problems[0]).startswith(caret)
    if message is not None:
        assert str(all_problems[0]).splitlines()[0].partition(": ")[2] == message


def test_accuracy_needs_a_figure_of_a_suitable_feature(write: Write) -> None:
    (problem,) = problems(write(f"{BASE}accuracy: 2 %\n{SWEEP}figures: [{{y: seconds, x: load}}]\n"))
    assert "no figure shows a spectral line" in problem.message
    assert text_at_caret(problem).startswith("accuracy: 2 %")


BESIDE = "`{}` cannot be combined with `accuracy`, which chooses it (remove `{}` or `accuracy`)"


@pytest.mark.parametrize(
    ("text", "key", "caret"),
    [
        ("model: ring\n", "model", "model: ring"),
        ("method: verlet\n", "method", "method: verlet"),
        ("quick: {model: ring}\n", "model", "model: ring"),
        ("quick: {method: rodas, duration: 0.2 s}\n", "method", "method: rodas"),
        ("quick: {sweep: {model: [ring, static]}}\n", "model", "model: [ring"),
        ("quick: {sweep: {zip: {model: [ring, static], load: [1 N, 2 N]}}}\n", "model", "model: [ring"),
    ],
)
def test_model_and_method_are_refused_with_accuracy(write: Write, text: str, key: str, caret: str) -> None:
    (problem,) = [p for p in problems(write(f"{BASE}{MODELS}{text}")) if "cannot be combined" in str(p)]
    assert str(problem).splitlines()[0].endswith(BESIDE.format(key, key))
    assert text_at_caret(problem).startswith(caret)


@pytest.mark.parametrize(
    ("sweep", "caret"),
    [
        ("sweep: {load: [150 N, 300 N], model: [ring, static]}\n", "model: [ring"),
        ("sweep: {zip: {load: [150 N, 300 N], model: [ring, static]}}\n", "model: [ring"),
        ("sweep: {zip: [{load: [150 N, 300 N], model: [ring, static]}]}\n", "model: [ring"),
        ("sweep: {load: [150 N, 300 N], method: [rodas, verlet]}\n", "method: [rodas"),
    ],
)
def test_swept_model_and_method_are_refused_with_accuracy(write: Write, sweep: str, caret: str) -> None:
    (problem,) = [
        p for p in problems(write(f"{BASE}accuracy: 2 %\n{sweep}{FIGURE}")) if "cannot be combined" in str(p)
    ]
    assert text_at_caret(problem).startswith(caret)


@pytest.mark.parametrize("key", ["model", "method"])
def test_overridden_model_and_method_are_refused_with_accuracy(write: Write, key: str) -> None:
    value = {"model": "ring", "method": "verlet"}[key]
    (problem,) = [p for p in problems(write(BASE + MODELS), {key: value}) if "cannot be combined" in str(p)]
    assert f"remove --set {key}" in str(problem)


STEPPED = "`{}` cannot be combined with `accuracy`, which needs the error bound of an automatic step (remove `{}` or `accuracy`)"
SWEPT = "`{}` cannot be swept with `accuracy`, which varies them in trials (give a single value)"
BENDS = "rig: {ring: {bends: true}}\n"


@pytest.mark.parametrize(
    ("text", "path", "caret", "message"),
    [
        ("step: 1 us\n", "step", "step: 1 us", STEPPED),
        ("tolerance: 1e-5\n", "tolerance", "tolerance: 1e-5", STEPPED),
        ("quick: {step: 1 us}\n", "step", "step: 1 us", STEPPED),
        ("quick: {sweep: {tolerance: [1e-5, 1e-6]}}\n", "tolerance", "tolerance: [1e-5", STEPPED),
        ("quick: {sweep: {contact.slices: [10, 20]}}\n", "contact.slices", "contact.slices: [10", SWEPT),
        (BENDS + "quick: {sweep: {rig.ring.harmonics: [8, 10]}}\n", "rig.ring.harmonics", "rig.ring.harm", SWEPT),
    ],
)
def test_step_and_refined_parameters_are_refused_with_accuracy(
    write: Write, text: str, path: str, caret: str, message: str
) -> None:
    (problem,) = problems(write(f"{BASE}{MODELS}{text}"))
    assert str(problem).splitlines()[0].endswith(message.format(path, path))
    assert text_at_caret(problem).startswith(caret)


@pytest.mark.parametrize(
    ("sweep", "caret"),
    [
        ("sweep: {load: [150 N, 300 N], step: [1 us, 2 us]}\n", "step: [1"),
        ("sweep: {zip: {load: [150 N, 300 N], tolerance: [1e-5, 1e-6]}}\n", "tolerance: [1e"),
        ("sweep: {load: [150 N, 300 N], contact.slices: [10, 20]}\n", "contact.slices: [10"),
        ("sweep: {zip: [{load: [150 N, 300 N], contact.slices: [10, 20]}]}\n", "contact.slices: [10"),
        (BENDS + "sweep: {load: [150 N, 300 N], rig.ring.harmonics: [8, 10]}\n", "rig.ring.harmonics: [8"),
        ("sweep: {load: [150 N, 300 N], step_check: [true, false]}\n", "step_check: [true"),
    ],
)
def test_swept_step_and_refined_parameters_are_refused_with_accuracy(write: Write, sweep: str, caret: str) -> None:
    (problem,) = problems(write(f"{BASE}accuracy: 2 %\n{sweep}{FIGURE}"))
    assert "`accuracy`" in problem.message
    assert text_at_caret(problem).startswith(caret)


@pytest.mark.parametrize(
    ("path", "value", "caret"),
    [
        ("step", "1 us", "accuracy: 2 %"),
        ("tolerance", "1e-5", "accuracy: 2 %"),
        ("step", "[1 us, 2 us]", "step=[1"),
        ("contact.slices", "[10, 20]", "contact.slices=[10"),
        ("step_check", "false", "accuracy: 2 %"),
    ],
)
def test_overridden_step_and_refined_parameters_are_refused_with_accuracy(
    write: Write, path: str, value: str, caret: str
) -> None:
    (problem,) = problems(write(BASE + MODELS), {path: value})
    assert "`accuracy`" in problem.message
    assert text_at_caret(problem).startswith(caret)


@pytest.mark.parametrize("text", ["step_check: false", "quick: {step_check: false}"])
def test_accuracy_needs_the_step_check(write: Write, text: str) -> None:
    (problem,) = problems(write(f"{BASE}{MODELS}{text}\n"))
    assert "`accuracy` needs `step_check`, which bounds the error of the step (remove `step_check: false`)" in str(
        problem
    )
    assert text_at_caret(problem).startswith("step_check: false")


@pytest.mark.parametrize(
    "text",
    [
        "step: auto\ntolerance: auto\n",
        "quick: {step: auto}\n",
        "step_check: strict\n",
        "contact: {slices: 10}\n",
        "quick: {contact.slices: 10}\n",
        "rig: {ring: {bends: true, harmonics: 10}}\n",
    ],
)
def test_compatible_settings_are_accepted_with_accuracy(write: Write, text: str) -> None:
    study = load_study(write(f"{BASE}{MODELS}{text}"))
    assert all(study.cases_with({"model": "static"}))


@pytest.mark.parametrize("rig", ["", BENDS, "rig: {ring: {bends: false}}\n"])
def test_unknown_support_is_refused_with_accuracy(write: Write, rig: str) -> None:
    """The advice must not lead to another refusal."""
    (problem,) = problems(write(f"{BASE}{MODELS}{rig}uncertainty: {{support: unknown}}\n"))
    assert problem.message.startswith("uncertainty.support: not possible with `accuracy`")
    assert problem.hint == "omit `support`, or use `model` instead of `accuracy`"
    assert text_at_caret(problem).startswith("unknown}")


def test_case_beyond_every_model_has_no_reference(write: Write) -> None:
    """No model has both the tilt of a roller over an offset defect and a flexible ring."""
    offset = BASE.replace("depth: 50 um", "depth: 50 um, offset: 1 mm")
    (problem,) = problems(write(f"{offset}{MODELS}rig: {{ring: {{bends: true}}}}\n"))
    assert problem.message.startswith("accuracy: no model can compute all of this: an `offset` tilts the roller")
    assert problem.hint == "omit that, or use `model` instead of `accuracy`"
    load_study(write(offset + MODELS))  # without the ring: spatial


@pytest.mark.parametrize(
    ("fields", "assumed"),
    [
        ("accuracy: {within: 2 %, of: [velocity.rms]}\n", (f"{TRIED_FRICTION} (docs/accuracy.md)",)),
        ("accuracy: {within: 2 %, of: [velocity.rms]}\nfriction: none\n", (NO_SLIP,)),
        ("accuracy: {within: 2 %, of: [velocity.rms]}\ncage: {pocket_clearance: 0.1 mm}\n", (NO_OIL,)),
        ("accuracy: {within: 2 %, of: [velocity.rms]}\ndrag: {oil_fraction: 0.1}\n", ()),
        ("accuracy: {within: 2 %, of: [velocity.rms]}\nrecord: [cage.slip]\n", (NO_OIL,)),
        ("model: rollers\n", ()),
    ],
)
def test_effects_omitted_by_the_reference_are_assumptions(
    write: Write, fields: str, assumed: tuple[str, ...]
) -> None:
    text = "study: a\nbearing: nf308\nspeed: 1800 rpm\nload: 150 N\nrig: {ring: {bends: false}}\n"
    assert load_study(write(text + fields)).assumptions == assumed


# Records that end early

DRAWN = "accuracy: 2 %\n{more}sweep: {{load: [100 N, 200 N]}}\nfigures: [{{y: [{y}], x: load}}]\n"


@pytest.mark.parametrize(
    ("more", "y", "until"),
    [
        ("", "velocity@BPFO, velocity.rms", 0.005),
        ("", "velocity@BPFO, seconds", 0.005),
        ("", "velocity@BPFO, outer_force.max", None),
        ("", "velocity@BPFO, velocity.kurtosis", None),
        ("", "velocity@BPFO, cage.slip.mean", None),
        ("", "velocity@BPFO, velocity@BPFO-healthy", None),
        ("record: [ring.velocity]\n", "velocity@BPFO", None),
        ("step_check: strict\n", "velocity@BPFO", None),
        ("until: 0.1 %\n", "velocity@BPFO", 0.001),
    ],
)
def test_records_end_early_if_figures_draw_means_only(
    write: Write, more: str, y: str, until: float | None
) -> None:
    cases = load_study(write(BASE + DRAWN.format(more=more, y=y))).cases()
    assert {case.until for case in cases} == {until}


def test_other_features_of_figures_are_monitored(write: Write) -> None:
    band = "velocity.rms@10-1000Hz"
    study = load_study(write(BASE + DRAWN.format(more="", y=f"velocity@BPFO, velocity@2BPFO, {band}")))
    assert {case.features for case in study.cases()} == {(band, "velocity@2BPFO")}
    features = {job.case.features for job in study.jobs() if job.is_baseline}
    assert features == {(band,)}


def test_an_accuracy_stores_no_series_unless_asked(write: Write) -> None:
    plain = DRAWN.format(more="", y="velocity@BPFO")
    stored = DRAWN.format(more="record: [ring.velocity]\n", y="velocity@BPFO")
    none, series, named = (
        load_study(write(BASE + text)).cases() for text in (plain, stored, "model: reference\n")
    )
    assert {case.record for case in none} == {()}
    assert {case.record for case in (*series, *named)} == {("ring.velocity",)}


@pytest.mark.parametrize(
    ("of", "features"),
    [
        ("velocity@BPFO, velocity.rms", ()),
        ("velocity@2BSF, acceleration.rms", ("velocity@2BSF", "acceleration.rms")),
        ("velocity@3BPFO-healthy, outer_force.max", ("velocity@3BPFO",)),
    ],
)
def test_own_until_monitors_the_features_of_the_accuracy(write: Write, of: str, features: tuple[str, ...]) -> None:
    """Otherwise the error at which the record ends would be that of other features."""
    text = DRAWN.format(more="until: 3 %\n", y=of).replace("2 %", f"{{within: 2 %, of: [{of}]}}")
    for case in load_study(write(BASE + text)).cases():
        assert (case.until, case.features) == (0.03, features)
