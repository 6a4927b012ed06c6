"""Summaries that notebooks show."""

import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import bearingsim as bs
from bearingsim.store import Results, Series
from bearingsim.study import Study

HOSTILE = "<script>alert('&')</script>"


@pytest.fixture
def study(study_folder: Path) -> Study:
    return bs.load_study("small.yaml")


class Texts(HTMLParser):
    """Texts of a page by their tag; a tag that is not a table's is an error."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tag, self.texts = "", dict[str, list[str]]()
        self.feed(page)

    def handle_starttag(self, tag: str, attributes: object) -> None:
        assert tag in ("table", "caption", "b", "tr", "th", "td")
        assert re.search("colo[u]?r|class|src", str(attributes)) is None
        self.tag = tag

    def handle_data(self, data: str) -> None:
        self.texts.setdefault(self.tag, []).append(data)


def rows(target: Study | bs.Case | Results | Series) -> tuple[str, dict[str, str]]:
    """The title and the rows of a summary."""
    page = target._repr_html_()
    assert len(page) < 3000
    texts = Texts(page).texts
    (title,) = texts["b"]
    return title, dict(zip(texts["th"], texts["td"], strict=True))


def test_study(study: Study) -> None:
    title, content = rows(study)
    assert title == "Study small"
    assert content["load"] == "2 values, 150 N to 300 N"
    assert content["model"] == "2 values, static to ring"
    assert (content["cases"], content["figures"]) == ("4", "1")


def test_ends_are_the_extremes_of_numbers_in_any_order(study_folder: Path) -> None:
    study = bs.load_study("small.yaml", {"load": "[200 N, 150 N, 300 N, 250 N]"})
    assert rows(study)[1]["load"] == "4 values, 150 N to 300 N"


def test_case(study: Study) -> None:
    title, content = rows(study.cases()[2])
    assert title == "Case"
    assert (content["bearing"], content["load"], content["speed"]) == ("NF308", "300 N", "1800 rpm")
    assert content["defect 1"].startswith("rectangular on outer: length 12 mm, width 0.8 mm, depth 0.05 mm")
    assert content["duration"] == "0.03 s"


def test_results(done: Path) -> None:
    title, content = rows(bs.open_results(done))
    assert title == "Results of small"
    assert content["jobs"] == "8 done"
    assert content["load"] == "2 values, 150 N to 300 N"


def test_series(done: Path) -> None:
    results = bs.open_results(done)
    title, content = rows(results.series(results.jobs[0]))
    assert title == "Series"
    assert content["time"].startswith("307 samples, 0 to 0.0298")
    assert content["ring.velocity.x"].endswith(" m/s")


def test_texts_are_escaped_and_control_characters_removed(tmp_path: Path) -> None:
    series = Series(np.zeros(0), {HOSTILE + "\x1b[2J": np.zeros(0, "f4")}, {HOSTILE + "\x1b[2J": HOSTILE})
    _, content = rows(series)
    assert content == {"time": "0 samples", HOSTILE + "[2J": f"- {HOSTILE}"}
