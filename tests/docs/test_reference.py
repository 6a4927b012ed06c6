"""Pages and tables that are written from the program and from measurements: they are current."""

import re
from pathlib import Path

import pytest

from bearingsim.catalogue import LAWS, MODELS
from bearingsim.study.paths import known_paths
from benchmarks.figures import SOURCES
from docs.scripts import tables
from docs.scripts.gallery import SECTIONS
from docs.scripts.keys import models_of_channel, models_of_example
from docs.scripts.markdown import table
from docs.scripts.navigation import DOCS
from docs.scripts.reference import PAGES


@pytest.mark.parametrize("name", PAGES)
def test_page_is_current(name: str) -> None:
    assert (DOCS / name).read_text(encoding="utf-8") == PAGES[name](), "run `make docs-reference`"


@pytest.mark.parametrize("page", list(tables.pages()), ids=lambda page: page.name)
def test_tables_of_a_page_are_current(page: Path) -> None:
    assert page.read_text(encoding="utf-8") == tables.current(page), "run `make docs-reference`"


def test_each_table_is_on_a_page() -> None:
    named = [
        block[2] for page in tables.pages() for block in tables.BLOCK.finditer(page.read_text(encoding="utf-8"))
    ]
    assert sorted(named) == sorted(tables.TABLES)


def test_a_block_that_is_not_current_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(tables.TABLES, "a b", lambda: "| x |")
    page = tmp_path / "page.md"
    page.write_text("text\n<!-- table: a b -->\n| old |\n| older |\n<!-- end of table -->\nrest\n")
    assert tables.current(page) == "text\n<!-- table: a b -->\n| x |\n<!-- end of table -->\nrest\n"


def test_gallery_shows_each_committed_figure_once() -> None:
    shown = [name for captions in SECTIONS.values() for name in captions]
    assert sorted(shown) == sorted(SOURCES)


def test_every_key_is_on_the_page() -> None:
    """A path such as `contact.damping.beta` is a row of a section `contact.damping`."""
    sections = re.split(r"^## ", PAGES["reference/keys.md"](), flags=re.MULTILINE)
    listed = set()
    for section in sections:
        title = re.match(r"`([a-z_.]+)`", section)
        keys = re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE)
        listed |= {f"{title[1]}.{key}" if title else key for key in keys}
    assert {path for path in known_paths() if not path.endswith(".law")} <= listed | {"defects"}
    assert all(f"law `{law}`" in "".join(sections) for law in (*LAWS["damping"], *LAWS["friction"]))


def test_models_of_keys_and_channels() -> None:
    assert models_of_example("misalignment") == "`spatial`"
    assert models_of_example("ramp") == "`planar`, `spatial`"
    assert "`impulse`" not in models_of_example("defect")
    assert models_of_channel("ring.velocity") == ""
    assert models_of_channel("roller.tilt") == "`spatial`"
    assert models_of_channel("ring.acceleration").count("`") == 2 * (len(MODELS) - 1)


def test_a_table_drops_empty_columns_and_escapes_bars_and_tags() -> None:
    assert table(("a", "b", "c"), [("x|y", "", "<z> `<u>`")]).splitlines()[::2] == [
        "| a | c |",
        "| x\\|y | &lt;z> `<u>` |",
    ]
