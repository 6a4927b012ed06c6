"""Links that somebody else has put into a results folder lead nothing out of it."""

import os
from typing import Any

import pytest

from bearingsim import store
from bearingsim.runner import run
from bearingsim.store import LinkWithin
from bearingsim.store.files import writer
from bearingsim.store.own_files import FOLDERS
from tests.scenes.fake_studies import ENGINE, FakeStudy


def marked(root: Any) -> Any:
    """A results folder without results."""
    store.claim_results(root, FakeStudy().name, quick=False)
    return root


@pytest.mark.parametrize("name", FOLDERS)
def test_a_link_for_a_folder_is_refused(tmp_path: Any, name: str) -> None:
    outside, root = tmp_path / "outside", marked(tmp_path / "results")
    outside.mkdir()
    link = root / name.replace("??", "ab")
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(outside)
    study: Any = FakeStudy()
    with pytest.raises(LinkWithin, match=f"{link} is a link"):
        run(study, root, jobs=1, progress=False, engine=ENGINE)
    assert not list(outside.iterdir())


@pytest.mark.skipif(not hasattr(os, "O_NOFOLLOW"), reason="this system follows links")
def test_no_journal_is_written_through_a_link(tmp_path: Any) -> None:
    precious, root = tmp_path / "precious", marked(tmp_path / "results")
    precious.write_text("precious")
    (root / f"journal-{writer()}.jsonl").symlink_to(precious)
    study: Any = FakeStudy()
    with pytest.raises(OSError, match="journal"):
        run(study, root, jobs=1, progress=False, engine=ENGINE)
    assert precious.read_text() == "precious"
