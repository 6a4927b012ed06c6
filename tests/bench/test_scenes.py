"""Scenes of `bearingsim bench`: built-in ones, those of a study, their variants, and refusals."""

import re

import pytest

from bearingsim.bench import measure, plan, scene
from bearingsim.errors import UserError
from tests.scenes.commands import type_


def test_every_scene_is_listed_and_can_be_computed_by_its_reference():
    assert {path.stem for path in scene.FOLDER.glob("*.yaml")} == set(scene.ORDER)
    for built_in in scene.built_in_scenes(scene.ORDER, quick=False):
        assert built_in.reference.duration <= scene.MAX_RECORD
        assert len(built_in.variants) >= 4
    assert set(plan.default_scenes(quick=True)) < set(scene.ORDER)


def test_unsuitable_model_is_refused_with_reason():
    bent = scene.built_in_scenes(["bent-ring"], quick=True)[0]
    refused = [variant for variant in bent.variants if variant.case is None]
    assert [variant.name for variant in refused] == ["ring"]
    run = next(run for run in plan.plan_runs(bent, quick=True) if run.variant == "ring")
    assert measure.compute_rows(run)[0]["failure"] == "refused"
    assert "cannot do this" in measure.compute_rows(run)[0]["reason"]


def test_a_step_over_the_limit_is_refused():
    run = next(
        candidate
        for candidate in plan.plan_runs(scene.built_in_scenes(["healthy"], quick=True)[0], quick=True)
        if candidate.variant == "ring" and candidate.setting.step == 16.0
    )
    result = measure.compute_rows(run)[0]
    assert result["failure"] == "refused"
    assert "limit" in result["reason"]


def test_unknown_scene_suggests_the_nearest(study_folder):
    _, err = type_("bench", "--scene", "slot-08", code=2)
    assert "unknown scene `slot-08`; did you mean `slot-0.8`?" in err


def test_wrong_study_is_reported_as_by_check(study_folder, write):
    path = write("study: wrong\nbearing: nf308\nspeed: 1800 rpm\nload: 150 kg\n")
    expected = type_("check", path, code=2)[1]
    assert type_("bench", path, code=2)[1] == expected
    assert re.search(r"150 kg", expected)


def test_study_and_scene_are_exclusive(study_folder):
    assert "not both" in type_("bench", "small.yaml", "--scene", "healthy", code=2)[1]


def test_a_ramp_is_refused(write):
    path = write(
        "study: up\nbearing: nf308\nspeed: 1800 rpm\nramp: {to: 3000 rpm, time: 1 s}\nload: 150 N\nmodel: planar\n"
    )
    with pytest.raises(UserError, match="omit `ramp`"):
        scene.load_scenes(path, quick=False)


def test_the_first_cases_of_a_study_are_scenes(study_folder):
    scenes = scene.load_scenes(study_folder / "small.yaml", quick=False)
    assert [case_scene.name for case_scene in scenes] == ["small-1", "small-2"]
    assert [case_scene.reference.load for case_scene in scenes] == [150.0, 300.0]
    assert [variant.name for variant in scenes[0].variants] == ["planar", "rollers", "ring", "static"]


def test_study_with_accuracy_has_the_same_models(write):
    path = write(
        "study: promised\nbearing: nf308\nspeed: 1800 rpm\nload: 150 N\n"
        "accuracy: {within: 2 %, of: [velocity.rms]}\n"
    )
    assert [variant.name for variant in scene.load_scenes(path, quick=False)[0].variants] == [
        "planar",
        "rollers",
        "ring",
        "static",
    ]


STUDY = "study: own\nbearing: nf308\nspeed: 1800 rpm\n"


def variants_of(path):
    return [{v.name: v for v in entry.variants} for entry in scene.load_scenes(path, quick=False)]


@pytest.mark.parametrize(
    "choice",
    [
        "method: rk4",
        "tolerance: 1e-4",
        "step: 1 us",
        "step_check: false\nperiodic: false",
        "sweep: {method: [rk4, rodas]}",
    ],
)
def test_automatic_choice_ignores_method_and_step_of_the_study(write, choice):
    (variants,) = variants_of(write(f"{STUDY}load: 150 N\n{choice}\n"))
    assert list(variants) == ["planar", "rollers", "ring", "static"]
    case = variants["rollers"].case
    assert (case.method, case.step, case.tolerance, case.step_check, case.periodic) == (
        "auto",
        "auto",
        "auto",
        True,
        True,
    )
    assert variants["static"].case.method is None


@pytest.mark.parametrize(
    ("harmonics", "names"),
    [(2, (4, 2)), (4, (8, 4)), (8, (16, 8)), (20, (40, 20, 8)), (100, (100, 8))],  # at most 100
)
def test_each_number_of_harmonics_is_one_variant(write, harmonics, names):
    path = write(f"{STUDY}load: 150 N\nrig: {{ring: {{harmonics: {harmonics}}}}}\n")
    (own_scene,) = scene.load_scenes(path, quick=True)
    assert [v.name for v in own_scene.variants[: len(names)]] == [f"rollers, {n} harmonics" for n in names]
    assert [v.name for v in own_scene.variants[len(names) :]] == ["ring", "static"]
    runs = list(plan.plan_runs(own_scene, quick=True))
    assert len({run.key for run in runs}) == len(runs)


def test_variants_are_of_the_case_of_their_reference(write):
    """With 8 harmonics cases that differ in harmonics are the same."""
    sweep = "sweep: {load: [150 N, 200 N, 300 N], rig.ring.harmonics: [10, 20]}"
    scenes = variants_of(write(f"{STUDY}{sweep}\n"))
    loads = [{v.case.load for v in variants.values() if v.case} for variants in scenes]
    assert loads == [{150.0}, {150.0}, {200.0}]
    assert all("rollers, 8 harmonics" in variants for variants in scenes)


def test_a_model_refused_for_one_case_computes_the_others(write):
    scenes = variants_of(write(f"{STUDY}load: 150 N\nsweep: {{rig.ring.bends: [false, true]}}\n"))
    assert [variants["ring"].case is None for variants in scenes] == [False, True]
    assert "cannot do this" in scenes[1]["ring"].refusal


def test_refusal_with_accuracy_is_not_that_of_the_keys(write):
    bent = "rig: {ring: {harmonics: 20}}\naccuracy: {within: 2 %, of: [velocity.rms]}\n"
    (variants,) = variants_of(write(f"{STUDY}load: 150 N\n{bent}"))
    assert variants["ring"].refusal == "the model cannot compute this case"
