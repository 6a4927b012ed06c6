"""Merge of results folders, which equals a single run and refuses damaged or contradictory results."""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bearingsim import selection, store
from bearingsim.runner import run
from bearingsim.selection import Choice
from bearingsim.store.sealed import write_json
from bearingsim.study.measured_values import MeasuredPoint, MeasuredSet, SignalFile
from tests.scenes.commands import type_
from tests.scenes.fake_studies import ENGINE, FakeStudy, record_of

WIDTHS = [1e-3 * (i + 1) for i in range(7)]  # and the healthy case
REASON = "the ring left"


def make_folder(
    root: Path, study: Any, units: Sequence[Sequence[int]], failed: Sequence[int] = (), host: str = "a"
) -> Path:
    """Make a results folder of a study with units of these jobs (numbers) and failed jobs, computed by a host."""
    root.mkdir(parents=True)
    jobs = study.jobs()
    store.write_plan(root, study, jobs)
    for unit in units:
        done = [(jobs[number], record_of(jobs[number].case)) for number in unit]
        for _, record in done:
            record.info["cpu_s"] = float(len(host))
        store.write_units(root, done, {"host": host})
    for number in failed:
        store.Failure(jobs[number].id, REASON, when=f"2026-01-0{len(host)}").write(root)
    return root


def table_of(root: Path) -> pd.DataFrame:
    """Return the table without unit and time."""
    return store.open_results(root).table().drop(columns=["unit", "seconds"])


def read_files(*roots: Path) -> dict[Path, tuple[bytes, int]]:
    """Read all files of some folders: bytes, and modification time."""
    files = [path for root in roots for path in sorted(root.rglob("*")) if path.is_file()]
    return {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in files}


unit_lists = st.lists(st.lists(st.integers(0, len(WIDTHS)), min_size=1, unique=True), max_size=3)


@settings(max_examples=25)
@given(st.lists(unit_lists, min_size=1, max_size=3), st.integers(0, len(WIDTHS)))
def test_any_split_and_overlap_gives_the_table_of_a_single_run(
    tmp_path_factory: pytest.TempPathFactory, splits: list[list[list[int]]], failed_job: int
) -> None:
    root, study = tmp_path_factory.mktemp("merge"), FakeStudy(WIDTHS)
    job_numbers = {number for units in splits for unit in units for number in unit}
    failed = [failed_job] if failed_job not in job_numbers else []
    single = make_folder(root / "single", study, [sorted(job_numbers)] if job_numbers else [], failed)
    shards = [
        make_folder(root / str(k), study, units, failed if k == 0 else [], host="x" * (k + 1))
        for k, units in enumerate(splits)
    ]
    files_before = read_files(*shards)
    merged = store.merge(shards, root / "out")
    assert merged.jobs["done"] == len(job_numbers)
    assert merged.jobs["failed"] == len(failed)
    pd.testing.assert_frame_equal(table_of(root / "out"), table_of(single), check_exact=True)
    for path in [path for shard in shards for path in shard.glob("units/??/*.h5")]:
        paths = [path_before for path_before in files_before if path_before.name == path.name]
        assert store.unit_path(root / "out", path.stem).read_bytes() in [
            files_before[path_before][0] for path_before in paths
        ]
    files_after = read_files(root / "out")
    repeated = store.merge(shards, root / "out")
    assert (repeated.copied, repeated.jobs) == (0, merged.jobs)
    assert read_files(root / "out") == files_after
    assert read_files(*shards) == files_before


def test_three_shards_give_the_table_of_a_single_run(tmp_path: Path) -> None:
    study: Any = FakeStudy(WIDTHS, actions={2: "raise", 5: "divide"})
    run(study, tmp_path / "single", jobs=1, progress=False, engine=ENGINE)
    shards = [tmp_path / f"shard{k}" for k in (1, 2, 3)]
    for k, shard in enumerate(shards, 1):
        run(study, shard, jobs=1, progress=False, engine=ENGINE, shard=(k, 3))
    output, _ = type_("merge", *shards, "--out", tmp_path / "out")
    assert output.splitlines()[0] == "3 folders merged: 3 units copied; 6 done, 2 failed of 8 jobs"
    pd.testing.assert_frame_equal(table_of(tmp_path / "out"), table_of(tmp_path / "single"), check_exact=True)
    assert (tmp_path / "out/study.yaml").read_bytes() == (tmp_path / "single/study.yaml").read_bytes()
    resumed = run(study, tmp_path / "out", jobs=1, progress=False, engine=ENGINE)
    assert (resumed.resumed, resumed.done, resumed.failed) == (6, 0, 2)


@pytest.fixture(scope="module")
def two_shards(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Make two folders that together contain all jobs of a study."""
    root, study = tmp_path_factory.mktemp("merge"), FakeStudy(WIDTHS)
    return [make_folder(root / name, study, [jobs]) for name, jobs in (("a", [0, 1, 7]), ("b", [2, 3, 4, 5, 6]))]


@given(st.data())
def test_any_changed_bit_in_a_unit_prevents_the_merge(two_shards: list[Path], data: st.DataObject) -> None:
    [path] = data.draw(st.sampled_from(two_shards)).glob("units/??/*.h5")
    content = path.read_bytes()
    changed_content = bytearray(content)
    changed_content[data.draw(st.integers(0, len(changed_content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    out = path.parents[3] / "out"
    path.write_bytes(bytes(changed_content))
    try:
        with pytest.raises(store.DamagedUnit, match=path.name):
            store.merge(two_shards, out)
    finally:
        path.write_bytes(content)
    assert not out.exists()


@pytest.mark.parametrize("quantity", ["feature", "series", "time"])
@pytest.mark.parametrize("numbers", [[1, 2], [0, 1]], ids=["another unit", "the same unit"])
def test_a_job_with_other_results_is_refused_with_both_paths(
    tmp_path: Path, quantity: str, numbers: list[int]
) -> None:
    study = FakeStudy(WIDTHS)
    first, second = make_folder(tmp_path / "a", study, [[0, 1]]), make_folder(tmp_path / "b", study, [])
    jobs = study.jobs()
    records = [record_of(jobs[number].case) for number in numbers]
    changed_record = records[numbers.index(1)]
    for record in records:
        if quantity == "time":
            record.time[-1] += 1e-12
    if quantity == "feature":
        changed_record.features["velocity@BPFO"] *= 1.0 + 1e-15
    if quantity == "series":
        changed_record.series["ring.velocity.y"][-1] += 1e-6
    [second_unit] = store.write_units(
        second, [(jobs[number], record) for number, record in zip(numbers, records, strict=True)], {}
    )
    [first_unit] = first.glob("units/??/*.h5")
    with pytest.raises(store.Unmergeable) as error:
        store.merge([first, second], tmp_path / "out")
    assert all(
        text in str(error.value)
        for text in (str(first_unit), str(second_unit), jobs[1].id if quantity != "time" else "time")
    )
    assert not (tmp_path / "out").exists()


def test_features_of_other_jobs_in_a_unit_do_not_prevent_a_merge(tmp_path: Path) -> None:
    study = FakeStudy(WIDTHS)
    first, second = make_folder(tmp_path / "a", study, [[0]]), make_folder(tmp_path / "b", study, [])
    jobs = study.jobs()
    records = [record_of(jobs[number].case) for number in (0, 1)]
    records[1].features |= {"cage.slip.mean": 0.1}
    store.write_units(second, list(zip(jobs, records, strict=False)), {})
    assert store.merge([first, second], tmp_path / "out").jobs["done"] == 2


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"name": "another"}, '`study` differs ("fake" and "another")'),
        ({"widths": WIDTHS[:5]}, "2 jobs are only in the first, 0 only in the second"),
        ({"overrides": {"load": "1 N"}}, '`overrides` differs ({"load": "200 N"} and {"load": "1 N"})'),
        ({"quick": True}, "`quick` differs (false and true)"),
        ({"units": {"defect.width": "um"}}, "`units` differs"),
    ],
)
def test_other_plans_are_refused_with_the_difference(tmp_path: Path, fields: dict[str, Any], message: str) -> None:
    first = make_folder(tmp_path / "a", FakeStudy(WIDTHS), [[0]])
    second = make_folder(tmp_path / "b", FakeStudy(**{"widths": WIDTHS} | fields), [[1]])
    with pytest.raises(store.Unmergeable) as error:
        store.merge([first, second], tmp_path / "out")
    assert message in str(error.value)
    assert all(str(path) in str(error.value) for path in (first, second))


def test_another_version_of_the_model_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = make_folder(tmp_path / "a", FakeStudy(WIDTHS), [[0]])
    monkeypatch.setattr("bearingsim.core.MODEL_VERSION", 1)
    second = make_folder(tmp_path / "b", FakeStudy(WIDTHS), [[1]])
    with pytest.raises(store.Unmergeable, match=r"`model_version` differs \(\d+ and 1\)"):
        store.merge([first, second], tmp_path / "out")


def test_path_of_the_study_file_may_differ(tmp_path: Path) -> None:
    first = make_folder(tmp_path / "a", FakeStudy(WIDTHS), [[0]])
    second = make_folder(tmp_path / "b", FakeStudy(WIDTHS, path=Path("/elsewhere/fake.yaml")), [[1]])
    assert store.merge([first, second], tmp_path / "out").jobs["done"] == 2


def test_folder_of_measured_signals_may_differ(tmp_path: Path) -> None:
    """The plan contains the absolute path of a signal, which is another one on each machine."""

    def folder_of(name: str, signal: str, unit: list[int]) -> Path:
        signals = SignalFile(signal, "1", "m/s^2")
        points = (MeasuredPoint({"load": 150.0}, {"velocity@BPFO": 1e-6}, "fake.yaml:5", signals),)
        study = FakeStudy(WIDTHS, measured=(MeasuredSet("rig", False, points),))
        return make_folder(tmp_path / name, study, [unit])

    first, second = folder_of("a", "/home/a/run1.wav", [0]), folder_of("b", "/home/b/run1.wav", [1])
    assert store.merge([first, second], tmp_path / "out").jobs["done"] == 2
    with pytest.raises(store.Unmergeable, match="`measured` differs"):
        store.merge([first, folder_of("c", "/home/a/run2.wav", [1])], tmp_path / "other")


def make_accuracy(within: float, notes: list[str]) -> dict[str, Any]:
    return {"within": within, "notes": notes, "of": [], "jobs": {}, "curves": [], "audits": []}


def test_notes_on_earlier_choices_may_differ(tmp_path: Path) -> None:
    folders = [make_folder(tmp_path / name, FakeStudy(WIDTHS), [[n]]) for n, name in enumerate("ab")]
    for root, notes in zip(folders, ([], ["3 choices were made for an earlier plan"]), strict=True):
        write_json(root / "plan.json", store.read_plan(root) | {"accuracy": make_accuracy(0.05, notes)})
    assert "2 units copied" in str(store.merge(folders, tmp_path / "out"))
    assert "1 unit copied" in str(store.merge(folders[:1], tmp_path / "one"))
    write_json(folders[1] / "plan.json", store.read_plan(folders[1]) | {"accuracy": make_accuracy(0.02, [])})
    with pytest.raises(store.Unmergeable, match="`accuracy` differs"):
        store.merge(folders, tmp_path / "other")


def test_results_in_the_output_folder_are_merged(tmp_path: Path) -> None:
    study = FakeStudy(WIDTHS)
    first, second = (
        make_folder(tmp_path / "a", study, [[0, 1]]),
        make_folder(tmp_path / "b", study, [[1, 2]], host="bb"),
    )
    merged = store.merge([second], first)
    assert (merged.copied, merged.existing, merged.jobs["done"]) == (1, 1, 3)
    other = make_folder(tmp_path / "c", FakeStudy(WIDTHS[:3]), [[0]])
    with pytest.raises(store.Unmergeable, match="two plans"):
        store.merge([other], first)


def test_a_folder_is_not_merged_into_itself(tmp_path: Path) -> None:
    first = make_folder(tmp_path / "a", FakeStudy(WIDTHS), [[0]])
    _, message = type_("merge", first, tmp_path / "a/../a", "--out", first, code=2)
    assert "is one of the merged folders" in message


def test_folders_without_results_are_refused(tmp_path: Path) -> None:
    first = make_folder(tmp_path / "a", FakeStudy(WIDTHS), [[0]])
    _, message = type_("merge", first, tmp_path / "b", "--out", tmp_path / "out", code=2)
    assert "b contains no results of a study" in message
    assert not (tmp_path / "out").exists()


def test_a_folder_without_its_study_file_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    first = make_folder(tmp_path / "a", FakeStudy(WIDTHS), [[0]])
    second = make_folder(tmp_path / "b", FakeStudy(WIDTHS), [[1]])
    (first / "study.yaml").unlink()
    _, message = type_("merge", first, second, "--out", tmp_path / "out", code=2)
    assert "a has no study.yaml: run the study there again" in " ".join(message.split())
    assert not (tmp_path / "out").exists()


def test_an_interrupted_merge_can_be_repeated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study = FakeStudy(WIDTHS)
    shards = [make_folder(tmp_path / str(k), study, [[k], [k + 3]]) for k in range(3)]
    copy, copied = store.merge.__globals__["copy"], []

    def copy_a_few(path: Path, target: Path) -> None:
        if len(copied) == 3:
            raise KeyboardInterrupt
        copied.append(path)
        copy(path, target)

    with monkeypatch.context() as patch:
        patch.setitem(store.merge.__globals__, "copy", copy_a_few)
        with pytest.raises(KeyboardInterrupt):
            store.merge(shards, tmp_path / "out")
    assert len([*tmp_path.glob("out/units/??/*.h5")]) == 3
    merged = store.merge(shards, tmp_path / "out")
    assert (merged.copied, merged.existing, merged.jobs["done"]) == (3, 3, 6)


def test_result_replaces_failures_and_the_latest_failure_counts(tmp_path: Path) -> None:
    study = FakeStudy(WIDTHS)
    first = make_folder(tmp_path / "a", study, [[0]], failed=[1, 2])
    second = make_folder(tmp_path / "b", study, [[1]], failed=[0, 2], host="bb")
    for number, order in enumerate([[first, second], [second, first]]):
        merged = store.merge(order, tmp_path / f"out{number}")
        assert merged.jobs == {"done": 2, "failed": 1, "missing": 5}
        [failure] = store.read_failures(tmp_path / f"out{number}").values()
        assert (failure.job, failure.when) == (study.jobs()[2].id, "2026-01-02")


TRIAL_NAMES = [letter * 16 for letter in "abc"]


def test_scans_trials_and_choices_are_merged(tmp_path: Path) -> None:
    from bearingsim.config.scan.file import digest_of

    study = FakeStudy(WIDTHS)
    first, second = make_folder(tmp_path / "a", study, [[0]]), make_folder(tmp_path / "b", study, [[1]])
    scan = first / "scans" / f"{digest_of(b'1 2 3')}.csv"
    scan.parent.mkdir()
    scan.write_bytes(b"1 2 3")
    choices = {name: Choice("ring", "ring", "cheap", {}) for name in ("one", "two", "three")}
    store.write_choices(first, {name: choices[name] for name in ("one", "two")}, {"one": "p"})
    store.write_choices(second, {name: choices[name] for name in ("two", "three")}, {"three": "q"})
    for name, shard in ((TRIAL_NAMES[0], first), (TRIAL_NAMES[1], second)):
        selection.write_trials(shard, name, {f"trial of {name}": None})
    (second / f"trials/{TRIAL_NAMES[2]}.json").write_text("{")
    out = tmp_path / "out"
    store.merge([first, second], out)
    assert (out / "scans" / scan.name).read_bytes() == b"1 2 3"
    assert store.read_choices(out) == choices
    assert store.read_plans(out)["three"] == "q"
    assert set(selection.read_trials(out)) == {f"trial of {name}" for name in TRIAL_NAMES[:2]}
    assert sorted(path.name for path in (out / "trials").iterdir()) == [f"{name}.json" for name in TRIAL_NAMES[:2]]
    store.write_choices(second, {"two": Choice("planar", "planar", "near", {})})
    with pytest.raises(store.Unmergeable, match="chose different models"):
        store.merge([first, second], tmp_path / "other")
    scan.write_bytes(b"1 2 4")
    shutil.rmtree(out)
    _, message = type_("merge", first, "--out", out, code=2)
    assert f"{scan.name}` has been changed" in message
    assert not out.exists()


def test_choices_in_the_output_folder_are_kept(tmp_path: Path) -> None:
    """`check --pilots --out DIR` chooses models before the shards, and `merge --out DIR` collects these."""
    first, out = make_folder(tmp_path / "a", FakeStudy(WIDTHS), [[0]]), tmp_path / "out"
    choices = {name: Choice("ring", "ring", "cheap", {}) for name in ("one", "two")}
    store.claim_results(out, "fake", quick=False)
    store.write_choices(out, choices, {"one": "p", "two": "q"})
    store.write_choices(first, {"one": choices["one"]}, {"one": "p"})
    store.merge([first], out)
    assert store.read_choices(out) == choices
    assert store.read_plans(out) == {"one": "p", "two": "q"}
    store.write_choices(first, {"two": Choice("planar", "planar", "near", {})})
    with pytest.raises(store.Unmergeable, match="chose different models"):
        store.merge([first], out)


def test_study_file_of_a_merged_folder_is_a_copy(tmp_path: Path) -> None:
    """The user's own study file stays where it is, so that an edited study may use the merged folder."""
    folder, out = tmp_path / "a", tmp_path / "out"
    study = FakeStudy(WIDTHS, path=folder / "study.yaml")
    store.claim_results(folder, study.name, quick=False)
    (folder / "study.yaml").write_text(study.text)
    run(study, folder, jobs=1, progress=False, engine=ENGINE)  # type: ignore[arg-type]
    store.merge([folder], out)
    edited = FakeStudy(WIDTHS[:3], text="study: fake\nload: 170 N\n")
    summary = run(edited, out, jobs=1, progress=False, engine=ENGINE)  # type: ignore[arg-type]
    assert summary.resumed == 4
    assert (out / "study.yaml").read_text() == edited.text
    assert (folder / "study.yaml").read_text() == study.text


def test_journal_records_a_merge_once(tmp_path: Path) -> None:
    first = make_folder(tmp_path / "a", FakeStudy(WIDTHS), [[0]])
    for _ in range(2):
        store.merge([first], tmp_path / "out")
    [journal] = (tmp_path / "out").glob("journal-*.jsonl")
    [line] = map(json.loads, journal.read_text().splitlines())
    assert (line["event"], line["folders"], line["units"]) == ("merged", [str(first)], 1)
