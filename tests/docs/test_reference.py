"""Reference pages of the documentation: they describe the program as it is."""

import re

import pytest

from bearingsim.catalogue import LAWS, MODELS
from bearingsim.study.paths import known_paths
from docs.scripts.keys import models_of_channel, models_of_example
from docs.scripts.markdown import table
from docs.scripts.reference import FOLDER, PAGES


@pytest.mark.parametrize("name", PAGES)
def test_page_is_current(name: str) -> None:
    assert (FOLDER / name).read_text(encoding="utf-8") == PAGES[name](), "run `make docs-reference`"


def test_every_key_is_on_the_page() -> None:
    """A path such as `contact.damping.beta` is a row of a section `contact.damping`."""
    sections = re.split(r"^## ", PAGES["keys.md"](), flags=re.MULTILINE)
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
