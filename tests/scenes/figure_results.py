"""Results folders whose numbers are known, for figures, and what tests read from a figure."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bearingsim import store
from bearingsim.study import load_study

STUDY = """\
study: known
bearing: nf308
speed: 1800 rpm
load: 150 N
clearance: 5 um
defect: {shape: circular, length: 3 mm, width: 0.8 mm, depth: 0.05 mm}
sweep:
  defect.length: [3 mm, 6 mm, 9 mm]
  load: [150 N, 300 N]
  model: [static, ring]
duration: 0.2 s
"""
FIGURES = """\
figures:
  - {y: [velocity@BPFO, velocity@BPFO-healthy], x: defect.length, by: load, panels: model}
"""
BPFO = 159.0


def amplitude(case):
    """The line (m/s) of a made-up result: 2 um/s per mm and 1 um/s per 150 N; healthy 0.5 um/s."""
    if not case.defects:
        return 0.5e-6
    return 2e-3 * case.defects[0].length + case.load / 150.0 * 1e-6


def phase(case):
    """Phase (rad) of the made-up line: that of a defect that turns with its angle; healthy 0."""
    return -13.0 * case.defects[0].angle - 0.5 if case.defects else 0.0


def record(case):
    time = np.arange(round(case.duration * case.sampling)) / case.sampling
    wave = amplitude(case) * np.cos(2.0 * math.pi * BPFO * time)
    series = {"ring.velocity.x": wave, "ring.velocity.y": 0.0 * wave} if case.record else {}
    features = {
        "velocity@BPFO": amplitude(case),
        "velocity@BPFO.phase": phase(case),
        "velocity@BPFO-scatter": 1e-19 * (1.0 + case.load),
        "velocity.rms": 1e3 * amplitude(case),
    }
    return SimpleNamespace(time=time, series=series, features=features, info={"cpu_s": 0.1})


@pytest.fixture
def results(tmp_path, constant_candidates):
    """A function that makes a results folder of a study text; ``lost`` maps the number of a job to its status."""

    def make(text=STUDY + FIGURES, lost=None, **options):
        file = tmp_path / "study.yaml"
        file.write_text(text)
        study, root = load_study(file, **options), tmp_path / "results"
        root.mkdir()
        jobs, lost = study.jobs(), lost or {}
        store.store_scans(root, [job.case for job in jobs])
        store.write_plan(root, study, jobs)
        done = [(job, record(job.case)) for number, job in enumerate(jobs) if number not in lost]
        store.write_units(root, done, {})
        for number, status in lost.items():
            if status == "failed":
                store.Failure(jobs[number].id, "the ring left", "shorten the step").write(root)
        return store.open_results(root)

    return make


def only(sheets):
    [(name, canvas)] = sheets
    return name, canvas


def lines(ax):
    """Curves of axes by x and y, without markers of lost jobs and levels of the healthy bearing."""
    curves = [line for line in ax.lines if line.get_gid() != "healthy"]
    return [line for line in curves if line.get_marker() not in ("x", "|") or len(line.get_xdata()) > 2]


def text_of(canvas):
    return [entry.get_text() for entry in canvas.legends[0].get_texts()]


def long_curves(ax):
    """Curves of axes by more than two points: no marks."""
    return [line for line in ax.lines if len(line.get_xdata()) > 2]
