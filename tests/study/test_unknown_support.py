"""`uncertainty: {support: unknown}`, and the assumption of a rigid outer ring."""

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from bearingsim import store
from bearingsim.plots.plot import draw_figures
from bearingsim.runner.findings import assumption_notes
from bearingsim.store.table import job_frame
from bearingsim.study import case_id, load_study
from bearingsim.study.uncertainty import PARAMETER_KINDS, RIGID_RING, SUPPORTS, UncertainParameter
from tests.scenes.commands import type_
from tests.scenes.study_text import BASE, Write

UNKNOWN = "uncertainty: {support: unknown}\n"
LOADS = (
    "{by: point}",
    "{by: pads, angles: [-45 deg, 45 deg]}",
    "{by: housing, stiffness: 1e10 N/m/m}",
    "{by: housing, stiffness: 1e11 N/m/m}",
)
NAMES = "support (point load, two pads at 45 deg, housing of 1e10 N/m/m, housing of 1e11 N/m/m)"


def command_output(command: str, path: Path, code: int = 0) -> str:
    return " ".join(" ".join(type_(command, path, code=code)).split())


# What is tried


def test_unknown_support_is_varied_over_four_supports(write: Write) -> None:
    study = load_study(write(BASE + UNKNOWN))
    assert study.uncertainty == (UncertainParameter("support", (1.0, 2.0, 3.0, 4.0)),)
    assert [variation.value for variation in study.variations()] == [1.0, 2.0, 3.0, 4.0]
    assert len({job.id for job in study.jobs()}) == 1 + 1 + 4  # the case, its baseline, the supports


def test_variation_of_support_has_the_id_of_the_same_written_rig(write: Write) -> None:
    tried = [variation.job.id for variation in load_study(write(BASE + UNKNOWN)).variations()]
    rigs = [f"rig: {{ring: {{bends: true}}, load: {load}}}\n" for load in LOADS]
    assert tried == [case_id(load_study(write(BASE + rig)).cases()[0]) for rig in rigs]
    assert len(SUPPORTS) == len(LOADS)


def test_variations_differ_in_ring_and_load_only(write: Write) -> None:
    (case,), variations = (
        load_study(write(BASE + UNKNOWN)).cases(),
        load_study(write(BASE + UNKNOWN)).variations(),
    )
    for variation in variations:
        rig = variation.job.case.rig.model_copy(update={"ring": None, "load": None})
        assert variation.job.case.model_copy(update={"rig": rig}) == case


def test_supports_are_shown_by_their_names() -> None:
    support = PARAMETER_KINDS["support"]
    assert support.range_text([1.0, 3.0, 1.0]) == "point load, housing of 1e10 N/m/m"
    assert support.text("support", [1.0, 2.0, 3.0, 4.0]) == NAMES
    assert PARAMETER_KINDS["bracket"].text("bracket", [0.5, 2.0]) == "bracket of 0.5 to 2"


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        *(
            (
                f"model: {model}",
                f"the {model} model has no flexible ring"
                " (use `model: static` or `model: rollers`, or remove `support`)",
            )
            for model in ("impulse", "ring", "planar", "spatial")
        ),
        ("sweep: {model: [static, ring]}", "the ring model has no flexible ring"),
        (
            "rig: {ring: {bends: true}}",
            "the rig already defines the support of its ring (remove `support`, or use `bends: false`)",
        ),
        ("load_across: 5 N", "`by: point` exerts no force across the load line"),
        ("method: rodas", "`rodas` needs the Jacobian, which models with a flexible ring do not have"),
    ],
)
def test_unsuitable_unknown_support_is_refused(write: Write, fields: str, message: str) -> None:
    path = write(f"{BASE}{UNKNOWN}{fields}\n")
    _, text = type_("check", path, code=2)
    first, source, pointer = text.splitlines()
    assert first.startswith(f"{path}:6:24: uncertainty.support: {message}")
    assert source[pointer.index("^") :] == "unknown}"


def test_unknown_support_of_a_ring_stated_rigid_is_accepted(write: Write) -> None:
    study = load_study(write(f"{BASE}{UNKNOWN}rig: {{ring: {{bends: false}}}}\n"))
    assert len(study.variations()) == 4


# What comes out

RUN = """\
study: unheld
bearing: nf308
speed: 1800 rpm
model: static
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}
sweep: {load: [150 N, 300 N]}
duration: 30 ms
settle: 10 ms
figures: [{y: velocity.rms, x: load}]
uncertainty: {support: unknown}
"""


@pytest.fixture(scope="module")
def finished_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Results folder of a small study, and the output of its run."""
    folder = tmp_path_factory.mktemp("unheld")
    (folder / "unheld.yaml").write_text(RUN)
    output, _ = type_("run", folder / "unheld.yaml", "--jobs", "1", "--out", folder / "out")
    return folder, " ".join(output.split())


def test_run_reports_the_effect_of_the_support(finished_run: tuple[Path, str]) -> None:
    folder, output = finished_run
    table = store.open_results(folder / "out").table()
    rms = table["error.support.rms"].dropna()
    assert len(rms) == 2
    assert (rms > 0.0).all()
    assert "support changes velocity.rms by up to" in output
    assert f"`uncertainty`: {NAMES}, in each case" in command_output("check", folder / "unheld.yaml")


def test_figure_has_a_band_from_least_to_largest(finished_run: tuple[Path, str]) -> None:
    results = store.open_results(finished_run[0] / "out")
    plan = json.loads((finished_run[0] / "out" / "plan.json").read_text())
    assert [(variation["what"], variation["value"]) for variation in plan["variations"]] == [
        ("support", n + 1.0) for n in range(4)
    ] * 2
    [(_, canvas)] = draw_figures(results)
    (band,) = [each for each in canvas.axes[0].collections if isinstance(each, PolyCollection)]
    heights = np.asarray(band.get_paths()[0].vertices)[:, 1]
    features = job_frame(finished_run[0] / "out")["features/velocity.rms"]
    assert heights.max() / heights.min() == pytest.approx(
        results.spread("velocity.rms")["largest"].max() / results.spread("velocity.rms")["least"].min(), rel=1e-9
    )
    jobs = [plan["variations"][0]["of"], *(variation["job"] for variation in plan["variations"][:4])]
    first = results.spread("velocity.rms").loc[jobs[0]]
    assert (first["least"], first["largest"]) == (features[jobs].min(), features[jobs].max())
    (note,) = [text.get_text() for text in canvas.texts if "bars:" in text.get_text()]
    assert NAMES in " ".join(note.replace("\u00a0", " ").split())


# A study that says nothing of its ring


@pytest.mark.parametrize(
    ("fields", "is_assumed"),
    [
        ("", True),
        ("rig: {bracket_stiffness: 1e6 N/m}", True),
        ("model: planar", True),
        ("model: impulse", False),
        ("rig: {ring: {bends: false}}", False),
        ("rig: {ring: {bends: true}}", False),
        ("sweep: {rig.ring.bends: [true, false]}", False),
        (UNKNOWN, False),
        ("record: [roller.1.outer_force]", True),  # without figures the velocity of the ring is printed
        ("record: []", True),
        ("record: []\nsweep: {load: [1 N, 2 N]}\nfigures: [{y: outer_force.max, x: load}]", False),
        ("record: []\nsweep: {load: [1 N, 2 N]}\nfigures: [{y: velocity@BPFO, x: load}]", True),
        ("record: []\nsweep: {load: [1 N, 2 N]}\nfigures: [{y: acceleration.rms, x: load}]", True),
    ],
)
def test_rigid_ring_is_an_assumption_if_its_motion_is_evaluated(
    write: Write, fields: str, is_assumed: bool
) -> None:
    text = BASE if not fields.partition("sweep: {load")[1] else BASE.replace("load: 150 N\n", "")
    assert load_study(write(f"{text}{fields}\n")).assumptions.count(RIGID_RING) == is_assumed


def test_check_prints_the_assumption_once(write: Write) -> None:
    assert (
        command_output("check", write(f"{BASE}sweep: {{clearance: [0 um, 5 um]}}\n")).count("rigid ring assumed")
        == 1
    )
    assert "rigid ring" not in command_output("check", write(f"{BASE}rig: {{ring: {{bends: false}}}}\n"))


def test_run_and_provenance_contain_the_assumption(write: Write) -> None:
    study = load_study(write(BASE))
    assert store.provenance(study)["assumptions"] == RIGID_RING
    assert "assumptions" not in store.provenance(load_study(write(f"{BASE}rig: {{ring: {{bends: false}}}}\n")))


def test_old_results_assume_nothing(finished_run: tuple[Path, str]) -> None:
    """Plans of earlier versions have no entry for it."""
    plan = json.loads((finished_run[0] / "out" / "plan.json").read_text())
    frame = job_frame(finished_run[0] / "out")
    assert RIGID_RING in list(assumption_notes(plan | {"assumptions": [RIGID_RING]}, frame))
    del plan["assumptions"]
    assert RIGID_RING not in list(assumption_notes(plan, frame))
