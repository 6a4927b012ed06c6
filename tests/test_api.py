"""`import bearingsim as bs`, as a script uses it."""

import subprocess
import sys

import pytest

import bearingsim as bs

STUDY = """\
study: api
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {shape: circular, length: 6 mm, width: 0.8 mm, depth: 0.05 mm}
sweep: {load: [150 N, 300 N]}
model: static
duration: 30 ms
"""


@pytest.fixture
def study(tmp_path):
    file = tmp_path / "api.yaml"
    file.write_text(STUDY)
    return bs.load_study(file, {"load": "[200 N, 250 N]"})


def test_importing_costs_nothing():
    code = (
        "import sys, bearingsim as bs\nheavy = {'numba', 'numpy', 'scipy', 'pandas', 'h5py', 'pydantic', 'yaml'}\n"
        "print(sorted(heavy & set(sys.modules)), dir(bs))"
    )
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    names = ["Case", "__version__", "envelope_spectrum", "load_study", "open_results", "run", "simulate"]
    assert output.strip() == f"[] {[*names, 'spectrum']}"


def test_a_case_is_simulated(study):
    [first, second] = study.cases()
    assert (first.load, second.load) == (200.0, 250.0)
    record = bs.simulate(first)
    assert record.velocity.shape == (307, 2)
    assert record.features["velocity@BPFO"] > 0.0


def test_a_case_can_be_made_in_python():
    case = bs.Case.model_validate({"bearing": "nf308", "speed": 188.5, "load": 150.0})
    assert case.bearing.rollers == 13


def test_a_study_is_run_and_opened(study, tmp_path):
    result = bs.run(study, tmp_path / "out", jobs=1, progress=False)
    table = result.table()
    assert list(table["status"]) == ["done"] * 4
    assert len(result.series(table["job"][0]).time) == 307
    reopened = bs.open_results(tmp_path / "out")
    assert reopened.jobs == result.jobs


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        _ = bs.simulat
