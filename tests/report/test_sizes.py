"""Time and size of pages."""

import re
import time
from pathlib import Path

from bearingsim.report import figures, page, render
from bearingsim.report.page import make_page
from bearingsim.report.render import render_html
from tests.scenes import figure_results
from tests.scenes.figure_results import FIGURES, STUDY, results

__all__ = ["results"]

FIG16 = Path(__file__).parents[2] / "studies/fig16_angle.yaml"
ORIGINAL = figure_results.record


def record(case):
    made = ORIGINAL(case)
    made.features["outer_force.max"] = 1e8 * made.features["velocity@BPFO"]
    return made


def test_page_of_fig16_is_small_and_soon_written(results, monkeypatch):
    monkeypatch.setattr(figure_results, "record", record)
    opened = results(
        FIG16.read_text()
        .replace("accuracy: 2 %\n", "")
        .replace("friction: none", "friction: none\nrecord: [ring.velocity] ")
    )
    assert len(opened.planned) == 626
    start = time.process_time()
    text = render_html(make_page(opened))
    assert time.process_time() - start < 10.0
    assert len(text.encode()) < 1.4e6


def test_large_pages_list_omitted_content(results, monkeypatch):
    monkeypatch.setattr(render, "MAX_BYTES", 500_000)
    monkeypatch.setattr(render, "FEW_ROWS", 5)
    shown = make_page(results(STUDY + FIGURES))
    text = render_html(shown)
    assert text.count("<noscript>") == 1
    assert "base64" not in text[text.index("<noscript>") : text.index("</noscript>")]
    for reason in (
        "browsers without JavaScript",
        "signals of jobs, because of their size",
        "11 of 16 rows of the table",
    ):
        assert text.count(reason) == 1


def test_only_what_is_left_out_is_listed(results, monkeypatch):
    """Without a finished job there are no pictures and no signals; the table is shortened twice."""
    monkeypatch.setattr(page, "MAX_ROWS", 8)
    monkeypatch.setattr(render, "MAX_BYTES", 0)
    monkeypatch.setattr(render, "FEW_ROWS", 5)
    text = render_html(make_page(results(lost=dict.fromkeys(range(16), "missing"))))
    omitted = text[text.index('id="omitted"') : text.index("</ul>", text.index('id="omitted"'))]
    assert re.findall("<li>(.*)</li>", omitted) == ["11 of 16 rows of the table: results.csv has all"]


def test_too_many_jobs_have_no_charts(results, monkeypatch):
    monkeypatch.setattr(figures, "MAX_CHART_ROWS", 10)
    monkeypatch.setattr(page, "MAX_ROWS", 3)
    shown = make_page(results(STUDY + FIGURES))
    assert [chart.kind for chart in shown.charts] == ["signal", "signal"]
    assert len(shown.table.rows) == 3
    assert [text.partition(":")[0] for text in shown.omissions + shown.table.omissions] == [
        "12 jobs are too many for charts",
        "13 of 16 rows of the table",
    ]


def test_pictures_of_many_lines_are_stored_in_pixels(results, monkeypatch):
    opened = results(STUDY + "figures: [{kind: pit, where: {load: 150 N, model: ring, defect.length: 3 mm}}]\n")
    kinds = []
    for limit in (10_000_000, 10):
        monkeypatch.setattr(figures, "MAX_SVG_BYTES", limit)
        [picture] = make_page(opened).pictures
        kinds.append(picture.address.partition(";")[0])
    assert kinds == ["data:image/svg+xml", "data:image/png"]
