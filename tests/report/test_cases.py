"""`bearingsim report` on results of all kinds: a page, or a message."""

import tarfile
from pathlib import Path

import numpy as np
import pytest

from bearingsim.report.charts import round_positions
from bearingsim.report.signals import MAX_POINTS, reduce
from bearingsim.report.statements import list_failures
from bearingsim.study import load_study
from bearingsim.text.yamlfile import StudyError
from tests.plots.test_plot_designs import HEAD, SOBOL
from tests.scenes.commands import type_
from tests.scenes.figure_results import FIGURES, STUDY, results
from tests.store.test_results_of_before import ARCHIVE

__all__ = ["results"]

JOBS = range(16)
UNCERTAIN = "uncertainty: {clearance: [0 um, 10 um]}\n"
HEALTHY = STUDY.replace("defect: {shape: circular, length: 3 mm, width: 0.8 mm, depth: 0.05 mm}\n", "").replace(
    "  defect.length: [3 mm, 6 mm, 9 mm]\n", ""
)


def written(opened, *words):
    stdout, stderr = type_("report", opened.path, *words)
    assert stderr == ""
    return stdout, (opened.path / "report.html").read_text()


@pytest.mark.parametrize(
    ("text", "lost", "counts", "contained", "lacking"),
    [
        (HEAD, {}, "2 of 2 jobs done", "Envelope spectrum", "data-chart=\"2\""),
        (HEALTHY, {}, "4 of 4 jobs done", "Velocity amplitude at BPFO over load", "healthy bearing (dashed)"),
        (SOBOL, {}, "64 of 64 jobs done", "sobol design of 32 points", "Influence"),
        (STUDY + FIGURES, dict.fromkeys(JOBS, "failed"), "0 of 16 jobs done, 16 failed",
         "the ring left (shorten the step)", "data-chart="),
        (STUDY + FIGURES, {1: "missing", 2: "failed"}, "14 of 16 jobs done, 1 failed, 1 not computed yet",
         "×: failed job; |: job not computed yet", "no result yet"),
        (STUDY + UNCERTAIN, {16: "missing", 17: "failed"}, "38 of 40 jobs done, 1 failed, 1 not computed yet",
         "with clearance 0 to 10 µm", "no result yet"),
        (STUDY + FIGURES, dict.fromkeys(JOBS, "missing"), "0 of 16 jobs done, 16 not computed yet",
         "no result yet", "data-chart="),
    ],
    ids=["one job", "healthy", "design", "failures", "interrupted", "variations", "empty"],
)  # fmt: skip
def test_any_results_have_a_page(results, text, lost, counts, contained, lacking):
    stdout, page = written(results(text, lost))
    assert f"{counts}, " in stdout
    assert counts in page
    assert contained in page
    assert lacking not in page


def test_results_of_an_earlier_model_version_have_a_page(tmp_path):
    with tarfile.open(ARCHIVE) as archive:
        archive.extractall(tmp_path, filter="data")
    type_("report", tmp_path / "kept", "-o", tmp_path / "page.html")
    assert '<section class="chart"' in (tmp_path / "page.html").read_text()


def test_damaged_results_end_with_a_message(results):
    opened = results(STUDY + FIGURES)
    for unit in opened.path.glob("units/*/*.h5"):
        unit.write_bytes(unit.read_bytes()[:1000])
    stdout, stderr = type_("report", opened.path)
    assert "0 of 16 jobs done" in stdout
    assert "cannot be read" in stderr
    (opened.path / "plan.json").write_text("{}")
    _, stderr = type_("report", opened.path, code=2)
    assert "plan.json is damaged" in stderr


def test_named_jobs_have_their_signals_on_the_page(results):
    opened = results(STUDY + FIGURES)
    _, page = written(opened, "--series", opened.jobs[0], "--series", opened.jobs[5])
    assert page.count('<h2 id="chart') == 5
    assert page.count(">Signal: length 3 mm, load 150 N, model static<") == 1


def test_foreign_files_are_kept(results, tmp_path):
    opened, other = results(STUDY + FIGURES), tmp_path / "mine.html"
    other.write_text("<p>mine</p>")
    _, stderr = type_("report", opened.path, "-o", other, code=2)
    assert stderr == f"{other} exists and is not a report of bearingsim; use another --out, or move the file\n"
    assert other.read_text() == "<p>mine</p>"
    _, stderr = type_("report", opened.path, "-o", tmp_path, code=2)
    assert "is a folder: name a file" in stderr


@pytest.mark.parametrize("number", [3, 20])
def test_following_writes_the_page_until_no_job_or_variation_is_missing(results, monkeypatch, number):
    opened = results(STUDY + UNCERTAIN + FIGURES, {number: "missing"})
    reloads = []

    def finish(seconds):
        reloads.append('"reload":10.0' in (opened.path / "report.html").read_text())
        from bearingsim.store import Failure

        Failure(opened.planned[number], "the ring left", "").write(opened.path)

    monkeypatch.setattr("bearingsim.cli.reporting.time.sleep", finish)
    stdout, stderr = type_("report", opened.path, "--follow")
    assert reloads == [True]
    assert stdout.count("report.html: ") == 2
    assert stderr == "following the run; Ctrl-C ends this command, not the run\n"
    assert '"reload":null' in (opened.path / "report.html").read_text()


def test_failed_jobs_are_named_by_their_case(results):
    """The nominal clearance is that of the study: the case itself, not a variation of it."""
    text = STUDY.replace("  load: [150 N, 300 N]\n  model: [static, ring]\n", "")
    uncertain = "uncertainty: {clearance: [0 um, 10 um], bracket: [0.5, 2]}\n"
    failures = list_failures(results(text + uncertain, dict.fromkeys((0, 4, 7), "failed")))
    assert [failure.case for failure in failures] == [
        "length 3 mm",
        "length 3 mm, clearance 0 µm",
        "length 3 mm, bracket 2",
    ]


def test_following_waits_for_a_plan(results, monkeypatch):
    opened = results(STUDY + FIGURES)
    plan, hidden = opened.path / "plan.json", opened.path / "hidden.json"
    plan.rename(hidden)
    monkeypatch.setattr("bearingsim.cli.reporting.time.sleep", lambda _: hidden.rename(plan))
    stdout, stderr = type_("report", opened.path, "--follow")
    assert stderr.startswith("waiting for a run in ")
    assert "report.html: " in stdout


def test_no_study_is_named_like_a_script(write):
    with pytest.raises(StudyError):
        load_study(write(STUDY.replace("study: known", "study: '</script><img src=x onerror=alert(1)>'")))


def test_long_signals_keep_their_extremes():
    x = np.arange(50_000.0)
    y = np.sin(x)
    y[31_234] = 7.0
    kept, values = reduce(x, y)
    assert len(kept) <= MAX_POINTS
    assert values.max() == 7.0
    assert kept[values.argmax()] == 31_234.0
    assert values.min() == y.min()


def test_samples_far_from_zero_keep_their_places():
    """Samples at 51.2 kHz after 20 s, in ms: neighbours differ in the seventh digit."""
    time = 20_000.0 + np.arange(513) / 51.2
    assert round_positions(time) == pytest.approx(time, abs=0.01 / 51.2)
    assert round_positions([5.0, 5.0]) == [5.0, 5.0]


def test_page_is_opened_in_a_browser(results, monkeypatch):
    opened, addresses = results(STUDY + FIGURES), []
    monkeypatch.setattr("bearingsim.cli.reporting.webbrowser.open", addresses.append)
    _, stderr = type_("report", opened.path, "--open")
    assert addresses == [(opened.path / "report.html").as_uri()]
    assert "cannot start a browser" in stderr
    assert Path(opened.path / "report.html").exists()
