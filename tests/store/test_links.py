"""Links in a results folder, which are not followed out of it."""

import os
from typing import Any

import pytest

from bearingsim import store
from bearingsim.errors import DamageWarning, UserError
from bearingsim.runner import run
from bearingsim.store import LinkInFolder
from bearingsim.store.files import writer_name
from bearingsim.store.own_files import FOLDERS, LOCK
from tests.scenes.commands import type_
from tests.scenes.fake_studies import ENGINE, FakeStudy


def make_results_folder(root: Any) -> Any:
    """Make a results folder without results."""
    store.claim_results(root, FakeStudy().name, quick=False)
    return root


@pytest.mark.parametrize("name", [*FOLDERS, LOCK])
def test_link_in_place_of_a_folder_is_refused(tmp_path: Any, name: str) -> None:
    outside, root = tmp_path / "outside", make_results_folder(tmp_path / "results")
    outside.mkdir()
    link = root / name.replace("??", "ab")
    link.parent.mkdir(exist_ok=True)
    link.unlink(missing_ok=True)
    link.symlink_to(outside)
    study: Any = FakeStudy()
    with pytest.raises(LinkInFolder, match=f"{link} is a link"):
        run(study, root, jobs=1, progress=False, engine=ENGINE)
    assert not list(outside.iterdir())


@pytest.mark.parametrize("name", FOLDERS)
def test_no_command_follows_a_link_in_place_of_a_folder(tmp_path: Any, name: str) -> None:
    outside, root, study = tmp_path / "outside", tmp_path / "results", FakeStudy()
    run(study, root, jobs=1, progress=False, engine=ENGINE)  # type: ignore[arg-type]
    outside.mkdir()
    for ending in ("h5", "json", "damaged", "csv"):
        (outside / f"0123456789abcdef.{ending}").write_text("precious")
    before = {path: path.read_bytes() for path in outside.iterdir()}
    link = root / name.replace("??", "zz")
    if link.exists():
        link.rename(tmp_path / "before")
    link.symlink_to(outside)
    for arguments in (
        ["prune", root, "--no-dry-run"],
        ["plot", root],
        ["show", root],
        ["export", root, "--features", tmp_path / "table.csv"],
        ["merge", root, "--out", tmp_path / "merged"],
    ):
        assert f"{link.name} is a link" in " ".join(type_(*arguments, code=2)[1].split())
    assert {path: path.read_bytes() for path in outside.iterdir()} == before


@pytest.mark.parametrize("name", ["stability.csv", "runs.csv", "stability-ring-0.2-mm-slot-steps.png"])
def test_no_table_or_map_is_written_through_a_link(tmp_path: Any, name: str) -> None:
    precious, folder = tmp_path / "precious", tmp_path / "folder"
    precious.write_text("precious")
    store.claim(folder, "a map", "bearingsim stability", "elsewhere")
    (folder / name).symlink_to(precious)
    with pytest.raises(LinkInFolder, match=f"{name} is a link"):
        store.claim(folder, "a map", "bearingsim stability", "elsewhere")


@pytest.mark.skipif(not hasattr(os, "O_NOFOLLOW"), reason="this system follows links")
def test_no_journal_is_written_through_a_link(tmp_path: Any) -> None:
    precious, root = tmp_path / "precious", make_results_folder(tmp_path / "results")
    precious.write_text("precious")
    (root / f"journal-{writer_name()}.jsonl").symlink_to(precious)
    study: Any = FakeStudy()
    with pytest.raises(OSError, match="journal"):
        run(study, root, jobs=1, progress=False, engine=ENGINE)
    assert precious.read_text() == "precious"


def test_no_lock_is_taken_through_a_link(tmp_path: Any) -> None:
    precious, root = tmp_path / "precious", tmp_path / "results"
    precious.write_text("precious")
    root.mkdir()
    (root / LOCK).symlink_to(precious)
    with pytest.raises(LinkInFolder, match="is a link"), store.lock(root):
        pass
    assert precious.read_text() == "precious"


def make_link(path: Any) -> None:
    """Move a file and replace it by a link."""
    target = path.parents[3] / "elsewhere"
    path.rename(target)
    path.symlink_to(target)


def make_pipe(path: Any) -> None:
    path.unlink()
    os.mkfifo(path)


def make_sparse(path: Any) -> None:
    with path.open("r+b") as file:
        file.truncate(1 << 43)


@pytest.mark.parametrize("pattern", ["units/*/*.h5", "failed/*.json"])
def test_link_to_a_result_is_refused(tmp_path: Any, pattern: str) -> None:
    """In a folder of git-annex or DVC every file is a link, and its results are not to be computed again."""
    study, root = FakeStudy(actions={1: "raise"}), tmp_path / "results"
    run(study, root, jobs=1, progress=False, engine=ENGINE)  # type: ignore[arg-type]
    [path] = root.glob(pattern)
    target = tmp_path / "elsewhere"
    path.rename(target)
    path.symlink_to(target)
    (root / "study.h5").unlink()
    with pytest.raises(LinkInFolder, match=f"{path} is a link.*cp -rL"):
        run(study, root, jobs=1, progress=False, engine=ENGINE)  # type: ignore[arg-type]
    assert path.readlink() == target
    assert not [*root.rglob("*.damaged")]


@pytest.mark.parametrize("change", [make_pipe, make_sparse])
def test_special_file_counts_as_a_damaged_unit(tmp_path: Any, change: Any) -> None:
    study, root = FakeStudy(), tmp_path / "results"
    run(study, root, jobs=1, progress=False, engine=ENGINE)  # type: ignore[arg-type]
    [unit] = root.glob("units/*/*.h5")
    change(unit)
    with pytest.warns(DamageWarning, match="is not a file|more than the memory"):
        assert set(store.open_results(root).table()["status"]) == {"missing"}
    summary = run(study, root, jobs=1, progress=False, engine=ENGINE)  # type: ignore[arg-type]
    assert (summary.done, summary.resumed) == (4, 0)
    assert unit.is_file()
    assert not unit.is_symlink()


@pytest.mark.parametrize("name", ["plan.json", "study.yaml"])
def test_merge_does_not_copy_link_targets(tmp_path: Any, name: str) -> None:
    study, root = FakeStudy(), tmp_path / "a" / "b" / "c"
    run(study, root, jobs=1, progress=False, engine=ENGINE)  # type: ignore[arg-type]
    make_link(root / name)
    with pytest.raises(UserError, match=rf"{name}.*is a link"):
        store.merge([root], tmp_path / "out")
    assert not (tmp_path / "out" / name).exists()
