# ruff: noqa: E501 (a table of messages, one line each)
"""Designs in a sweep: samples, distributions, jobs and refusals."""

import json
import re
from dataclasses import asdict
from pathlib import Path

import pytest

from bearingsim import designs, selection, store
from bearingsim.designs import KINDS, Kind
from bearingsim.selection.choices import choice_key
from bearingsim.store.choices import Choice
from bearingsim.study import StudyError, case_id, load_study
from bearingsim.study.design import EXAMPLE
from bearingsim.study.paths import known_paths
from tests.scenes.designs import design_of, sweep, values
from tests.scenes.study_text import BASE, Write


def first_problem(path: Path, overrides: dict[str, str] | None = None, quick: bool = False) -> tuple[str, str]:
    """First message, and text at its caret."""
    with pytest.raises(StudyError) as caught:
        load_study(path, overrides, quick)
    problem = caught.value.problems[0]
    hint = f" ({problem.hint})" if problem.hint else ""
    return problem.message + hint, problem.source_line[problem.column - 1 :]


# What is drawn


@pytest.mark.parametrize("kind", KINDS)
def test_design_maps_points_of_the_unit_cube_to_its_paths(write: Write, kind: Kind) -> None:
    study = load_study(write(sweep(kind, 8)))
    cube = designs.unit_cube_points(kind, 8, 2, seed=1)
    assert values(study, "defect.width") == pytest.approx(0.2e-3 + 1.8e-3 * cube[:, 0], rel=1e-11)
    assert values(study, "load") == pytest.approx(50.0 * 10.0 ** cube[:, 1], rel=1e-11)
    design = design_of(study)
    assert (design.kind, design.n, design.seed, design.paths) == (kind, 8, 1, ("defect.width", "load"))
    assert len(design.ids) == 8 * designs.block_size(kind, 2)
    assert study.units == {"defect.width": "mm", "load": "N"}


def test_seed_is_zero_by_default(write: Write) -> None:
    text = f"{BASE}sweep: {{lhs: {{n: 4, over: {{load: [1 N, 2 N]}}}}}}\n"
    assert design_of(load_study(write(text))).seed == 0


def test_ranges_are_kept_in_si(write: Write) -> None:
    ranges = "load: [150 N, 0.3 kN], defect.width: {log: [0.2 mm, 2 mm]}"
    study = load_study(write(f"{BASE}sweep: {{sobol: {{n: 2, over: {{{ranges}}}}}}}\n"))
    assert design_of(study).ranges == ((150.0, 300.0), (0.0002, 0.002))


def test_equal_rows_are_one_case(write: Write) -> None:
    """Morris trajectories in two parameters share points: each row has the id of its case."""
    study = load_study(write(sweep("morris", 40)))
    design = design_of(study)
    assert len(study.cases()) <= len(designs.LEVELS) ** 2 < len(design.ids) == 120
    assert set(design.ids) == {case_id(case) for case in study.cases()}


def test_ids_are_unchanged(write: Write) -> None:
    """Other machines and versions of libraries must give the same digits."""
    over = "{defect.width: [0.2 mm, 2 mm], load: {log: [50 N, 500 N]}, speed: {normal: [1800 rpm, 90 rpm], within: [1500 rpm, 2000 rpm]}}"
    study = load_study(write(sweep("saltelli", 2, over)))
    rows = [[swept[path] for path in design_of(study).paths] for _, swept in study.swept_cases]
    assert rows[:2] == [
        [0.000715104491636, 72.7118690658, 190.41786060330833],
        [0.000716319520585, 162.421347177, 198.63202204625617],
    ]
    assert design_of(study).ids[:2] == ("9b83d243ec1c9c53", "583b72005fd82687")


@pytest.mark.parametrize(("kind", "kept_count"), [("sobol", 64), ("saltelli", 256), ("morris", 192), ("lhs", 0)])
def test_larger_design_keeps_the_ids_or_notes_that_it_does_not(write: Write, kind: str, kept_count: int) -> None:
    few, many = (load_study(write(sweep(kind, n))) for n in (64, 256))
    assert sum(a == b for a, b in zip(design_of(few).ids, design_of(many).ids, strict=False)) == kept_count
    assert any("cannot be extended" in note for note in many.notes) == (kept_count == 0)


def test_unbalanced_number_of_points_is_noted(write: Write) -> None:
    assert load_study(write(sweep("sobol", 64))).notes == ()
    assert load_study(write(sweep("sobol", 100))).notes == (
        "sobol: points are evenly spread only if `n` is a power of two, unlike 100",
    )


# What else a study says


def test_lists_multiply_a_sobol_design(write: Write) -> None:
    study = load_study(write(sweep("sobol", 4, more=", model: [ring, rollers]")))
    design = design_of(study)
    assert len(design.ids) == 8 == len(study.cases())
    models = {case_id(case): case.model for case in study.cases()}
    assert [models[name] for name in design.ids] == 4 * ["ring", "rollers"]


def test_where_removes_points(write: Write) -> None:
    full = load_study(write(sweep("sobol", 32)))
    some = load_study(write(sweep("sobol", 32, more=", where: [load < 200 N, defect.width > 0.5 mm]")))
    left = [
        name
        for name, load, width in zip(
            design_of(full).ids, values(full, "load"), values(full, "defect.width"), strict=True
        )
        if load < 200.0 and width > 0.5e-3
    ]
    assert 0 < len(left) < 32
    assert list(design_of(some).ids) == left


def test_quick_takes_fewer_points(write: Write) -> None:
    path = write(sweep("sobol", 64) + "quick: {sweep: {sobol: {n: 4}}}\n")
    full, quick = load_study(path), load_study(path, quick=True)
    assert design_of(quick).ids == design_of(full).ids[:4]


def test_quick_takes_another_design(write: Write) -> None:
    path = write(sweep("sobol", 64) + "quick: {sweep: {morris: {n: 2, over: {speed: [1000 rpm, 2000 rpm]}}}}\n")
    assert design_of(load_study(path, quick=True)).paths == ("speed",)


def test_quick_lists_a_path_of_the_design(write: Write) -> None:
    path = write(sweep("sobol", 64) + "quick: {sweep: {load: [100 N, 200 N], sobol: {n: 4}}}\n")
    study = load_study(path, quick=True)
    assert design_of(study).paths == ("defect.width",)
    assert sorted({case.load for case in study.cases()}) == [100.0, 200.0]
    assert len(study.cases()) == 8


def test_quick_draws_a_path_that_was_listed(write: Write) -> None:
    path = write(BASE + "sweep: {load: [1 N, 2 N]}\nquick: {sweep: {sobol: {n: 8, over: {load: [1 N, 2 N]}}}}\n")
    assert len(load_study(path, quick=True).cases()) == 8


@pytest.mark.parametrize(
    ("overrides", "paths", "count"),
    [
        ({"sobol.n": "4"}, ("defect.width", "load"), 4),
        ({"load": "200 N"}, ("defect.width",), 16),
        ({"load": "[200 N, 300 N]"}, ("defect.width",), 32),
        ({"load": "200 N", "defect.width": "1 mm"}, None, 1),
    ],
)
def test_command_line_overrides_the_design(
    write: Write, overrides: dict[str, str], paths: tuple[str, ...] | None, count: int
) -> None:
    study = load_study(write(sweep()), overrides)
    assert (study.design and study.design.paths, len(study.cases())) == (paths, count)


def test_another_seed_is_another_design(write: Write) -> None:
    path = write(sweep())
    first, second = load_study(path), load_study(path, {"sobol.seed": "2"})
    assert design_of(second).seed == 2
    assert not set(design_of(first).ids) & set(design_of(second).ids)


def test_a_figure_draws_paths_of_a_design(write: Write) -> None:
    more = ", derived: {defect.depth: defect.width / 40}"
    figures = "figures: [{y: velocity@BPFO, x: defect.depth, by: load}]\n"
    assert load_study(write(sweep(more=more) + figures)).figures[0].x == "defect.depth"


def test_figure_of_an_invalid_design_is_not_reported_as_well(write: Write) -> None:
    path = write(sweep("sobol", 0) + "figures: [{y: velocity@BPFO, x: load}]\n")
    with pytest.raises(StudyError) as caught:
        load_study(path)
    assert len(caught.value.problems) == 1


# Repeats


def test_repeat_tries_seeds(write: Write) -> None:
    text = BASE + "model: planar\nsweep: {load: [100 N, 200 N], repeat: 3}\n"
    study = load_study(write(text))
    assert [(case.load, case.seed) for case in study.cases()] == [
        (load, seed) for load in (100.0, 200.0) for seed in (1, 2, 3)
    ]
    assert len({case_id(case) for case in study.cases()}) == 6
    assert len(load_study(write(text), {"repeat": "5"}).cases()) == 10


@pytest.mark.parametrize("text", ["model: rollers", "model: planar\ncage: {motion: kinematic}"])
def test_repeat_of_a_deterministic_study_is_refused(write: Write, text: str) -> None:
    message, caret = first_problem(write(f"{BASE}{text}\nsweep: {{repeat: 3}}\n"))
    assert message.startswith("repeat: nothing in this study depends on `seed`")
    assert caret == "repeat: 3}"


def test_random_impulses_are_repeated(write: Write) -> None:
    text = BASE + "model: impulse\nexcitation: random-impulses\nsweep: {repeat: 3}\n"
    assert len(load_study(write(text)).cases()) == 3


# What is stored


def test_plan_contains_the_design(write: Write, tmp_path: Path) -> None:
    study = load_study(write(sweep("saltelli", 4)))
    store.write_plan(tmp_path, study, study.jobs())
    design = store.read_plan(tmp_path)["design"]
    assert design == json.loads(json.dumps(asdict(design_of(study))))
    assert set(design) == {"kind", "n", "seed", "paths", "ranges", "ids"}
    assert len(design["ranges"]) == len(design["paths"])
    assert set(design["ids"]) <= {job["job"] for job in store.read_plan(tmp_path)["jobs"]}


def test_a_plan_of_an_older_version_has_no_design(write: Write, tmp_path: Path) -> None:
    study = load_study(write(BASE))
    store.write_plan(tmp_path, study, study.jobs())
    plan = store.read_plan(tmp_path)
    assert plan.pop("design") is None
    store.sealed.write_json(tmp_path / "plan.json", plan)
    assert store.read_plan(tmp_path) == {"design": None} | plan


def test_with_an_accuracy_the_ids_are_those_of_the_models_chosen(write: Write) -> None:
    figures = "duration: 0.2 s\naccuracy: 5 %\nfigures: [{y: velocity@BPFO, x: load}]\n"
    study = load_study(write(sweep("saltelli", 4) + figures))
    choices = {choice_key(study, case): Choice("ring", "ring", "told", {}) for case in study.cases()}
    after = selection.apply_choices(study, choices)
    named = load_study(write(sweep("saltelli", 4) + "duration: 0.2 s\nmodel: ring\nrecord: []\nuntil: 1.25 %\n"))
    assert design_of(after) == design_of(named) != design_of(study)
    assert set(design_of(after).ids) <= {job.id for job in after.planned()}


# What is refused


@pytest.mark.parametrize(
    ("text", "message", "caret"),
    [
        ("sobol: {n: 1000000000, over: {load: [1 N, 2 N]}}", "sweep.sobol.n: 1000000000 points of 1 path are 1000000000 cases; at most 1000000 are possible", "1000000000"),
        ("saltelli: {n: 300000, over: {load: [1 N, 2 N], speed: [1 Hz, 2 Hz]}}", "sweep.saltelli.n: 300000 base points of 2 paths are 1200000 cases; at most 1000000 are possible", "300000"),
        (f"sobol: {{n: {'9' * 90}, over: {{load: [1 N, 2 N]}}}}", None, "999"),
        ("sobol: {n: 1e9, over: {load: [1 N, 2 N]}}", "sweep.sobol.n: expected the number of points, a whole number above zero, got `1e9`", "1e9"),
        ("morris: {n: 0, over: {load: [1 N, 2 N]}}", "sweep.morris.n: expected the number of trajectories, a whole number above zero, got `0`", "0,"),
        ("lhs: {n: [1], over: {load: [1 N, 2 N]}}", "sweep.lhs.n: expected the number of points, a whole number above zero, got `[1]`", "[1]"),
        ("lhs: {n: 4, seed: -1, over: {load: [1 N, 2 N]}}", "sweep.lhs.seed: expected a whole number from 0 to 999999999, got `-1`", "-1"),
        ("lhs: {n: 4, sed: 1, over: {load: [1 N, 2 N]}}", "sweep.lhs: unknown key `sed` (did you mean `seed`?)", "sed: 1"),
        ("sobl: {n: 5, over: {load: [1 N, 2 N]}}", "sweep: there is no design `sobl` (did you mean `sobol`?)", "sobl"),
        ("lhs: 5", f"sweep.lhs: expected a mapping such as `{EXAMPLE}`", "5}"),
        ("lhs: {n: 5}", f"sweep.lhs: `over` is missing (as in `lhs: {EXAMPLE}`)", "lhs: {n"),
        ("lhs: {over: {load: [1 N, 2 N]}}", f"sweep.lhs: `n` is missing (as in `lhs: {EXAMPLE}`)", "lhs: {over"),
        ("lhs: {n: 5, over: [load]}", "sweep.lhs.over: expected paths with their ranges, as in `{load: [100 N, 200 N]}`", "[load]"),
        ("lhs: {n: 5, over: {lod: [1 N, 2 N]}}", "no such path `lod` (did you mean `load`?)", "lod"),
        ("lhs: {n: 5, over: {model: [ring, rollers]}}", "sweep.lhs.over.model: only a quantity has a range (list values, as in `model: [...]` in `sweep`)", "model: [r"),
        ("lhs: {n: 5, over: {load: 3 N}}", "sweep.lhs.over.load: expected a range such as `[a, b]`, `{log: [a, b]}` or `{normal: [mean, deviation], within: [a, b]}`", "3 N"),
        ("lhs: {n: 5, over: {load: {lg: [1 N, 2 N]}}}", "sweep.lhs.over.load: expected a range such as `[a, b]`, `{log: [a, b]}` or `{normal: [mean, deviation], within: [a, b]}` (did you mean `log`?)", "{lg"),
        ("lhs: {n: 5, over: {load: [1 N, 2 N, 3 N]}}", "sweep.lhs.over.load: expected two values, as in `[a, b]`", "[1 N, 2 N, 3 N]"),
        ("lhs: {n: 5, over: {load: [2 N, 1 N]}}", "sweep.lhs.over.load: expected a value above `2 N`, got `1 N`", "1 N"),
        ("lhs: {n: 5, over: {load: [-1e308 N, 1e308 N]}}", "sweep.lhs.over.load: the range is larger than any number", "[-1e308 N"),
        ("lhs: {n: 5, over: {load: [1 N, 0.001 kN]}}", "sweep.lhs.over.load: expected a value above `1 N`, got `0.001 kN`", "0.001 kN"),
        ("lhs: {n: 5, over: {load: [1 N, 2 mm]}}", "sweep.lhs.over.load: expected a force such as `150 N`, got `2 mm` (`mm` is a unit of length)", "2 mm"),
        ("lhs: {n: 5, over: {load: [1 N, [2 N]]}}", "sweep.lhs.over.load: expected a number with its unit", "[2 N]"),
        ("lhs: {n: 5, over: {load: {log: [0 N, 2 N]}}}", "sweep.lhs.over.load: `log` needs values above zero", "0 N"),
        ("lhs: {n: 5, over: {contact.damping.temperature: {log: [20 C, 30 C]}}}", "sweep.lhs.over.contact.damping.temperature: a temperature has no logarithm (use `uniform`)", "20 C"),
        ("lhs: {n: 5, over: {load: {log: [1 N, 2 N], within: [1 N, 2 N]}}}", "sweep.lhs.over.load: unknown key `within` next to `log`", "within"),
        ("lhs: {n: 5, over: {load: {normal: [1 N, 2 N]}}}", "sweep.lhs.over.load: `within` is missing (a normal distribution needs bounds)", "normal"),
        ("lhs: {n: 5, over: {load: {normal: [1 N, 0 N], within: [1 N, 2 N]}}}", "sweep.lhs.over.load: expected a standard deviation above zero, got `0 N`", "0 N"),
        ("lhs: {n: 5, over: {load: {normal: [150 N, 1e300 N], within: [100 N, 200 N]}}}", "sweep.lhs.over.load: a standard deviation over 1000 times the range has no effect (use `uniform`)", "1e300 N"),
        ("lhs: {n: 5, over: {load: {normal: [150 N, 100.1 kN], within: [100 N, 200 N]}}}", "sweep.lhs.over.load: a standard deviation over 1000 times the range has no effect (use `uniform`)", "100.1 kN"),
        ("lhs: {n: 5, over: {load: {normal: [1 N, 1 N], within: [10 N, 20 N]}}}", "sweep.lhs.over.load: these are over 8 standard deviations from the mean", "[10 N"),
        ("lhs: {n: 5, over: {load: [1 N, 2 N]}, sobol: {n: 5}}", "sweep.lhs: unknown key `sobol` (valid: n, seed, over)", "sobol"),
        ("lhs: {n: 5, over: {load: [1 N, 2 N]}}, sobol: {n: 5, over: {load: [1 N, 2 N]}}", "sweep: a second design; a study has one", "sobol"),
        ("lhs: {n: 5, over: {load: [1 N, 2 N]}}, load: [1 N, 2 N]", "`load` is swept twice", "load: [1 N, 2 N]}"),
        ("saltelli: {n: 4, over: {load: [1 N, 2 N]}}, where: [load < 3 N]", "`where` next to `saltelli`, whose rows are compared in whole blocks (omit it; ranges and `derived` can restrict parameters)", "where"),
        ("morris: {n: 4, over: {load: [1 N, 2 N]}}, repeat: 3", "`repeat` next to `morris`, whose rows are compared in whole blocks (omit it, or use `sobol`)", "repeat"),
        ("morris: {n: 4, over: {load: [1 N, 2 N]}}, model: [ring, rollers]", "`model` is swept next to `morris`, whose rows are compared in whole blocks (give it one value, or a range in `over`)", "model"),
        ("repeat: 0", "sweep.repeat: expected a whole number from 1 to 100000, got `0`", "0}"),
        ("repeat: [2]", "sweep.repeat: expected a whole number from 1 to 100000, got a list", "[2]"),
        ("seed: [1, 2], repeat: 3", "`seed` is swept twice", "repeat"),
    ],
)  # fmt: skip
def test_invalid_entry_is_refused_at_its_position(
    write: Write, text: str, message: str | None, caret: str
) -> None:
    first_line, pointed = first_problem(write(f"{BASE}model: rollers\nsweep: {{{text}}}\n"))
    assert first_line == message or message is None
    assert pointed.startswith(caret)


def test_description_counts_the_remaining_points() -> None:
    from bearingsim.plots.design import describe_design

    design = {"kind": "sobol", "n": 32, "seed": 0, "ids": ("a",) * 24}
    assert describe_design(design) == "sobol design of 24 of 32 points, seed 0"
    assert describe_design(design | {"ids": ("a",) * 32}) == "sobol design of 32 points, seed 0"


def test_single_value_with_a_block_design_is_accepted(write: Write) -> None:
    assert len(load_study(write(sweep("saltelli", 4, more=", model: [ring]"))).cases()) == 16


def test_override_of_a_missing_design_is_refused(write: Write) -> None:
    message, caret = first_problem(write(BASE), {"sobol.n": "4"})
    assert message == "the study has no `sobol` (name it in `sweep`)"
    assert caret == "sobol.n=4"


def test_number_of_rows_decreases_with_the_number_of_paths(write: Write) -> None:
    paths = [path for path, dimension in known_paths().items() if dimension][:21]
    over = ", ".join(f"{path}: [1 N, 2 N]" for path in paths)
    message, caret = first_problem(write(sweep("sobol", 500_000, f"{{{over}}}")))
    assert message == (
        "sweep.sobol.n: 500000 cases of 21 paths are 10500000 values; at most 10000000 are possible"
    )
    assert caret.startswith("500000")


def test_too_large_product_is_refused_before_it_is_built(write: Write) -> None:
    text = sweep("sobol", 2048, more=", speed: {linspace: [10 Hz, 20 Hz, 1000]}")
    assert re.match("sweep: 2048000 cases; at most 1000000 are possible", first_problem(write(text))[0])
