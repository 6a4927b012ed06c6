"""Commands that read results do not import the simulation, which takes a second of CPU time."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from bearingsim import simulation
from bearingsim.core.jit import compilation_callbacks
from tests.scenes.commands import STUDY, type_

READING = [
    ["show"],
    ["show", "--assumptions"],
    ["show", "--json"],
    ["plot"],
    ["plot", "--kind", "series", "--job", "all"],
    ["plot", "--kind", "spectrum", "--job", "all"],
    ["plot", "--kind", "envelope", "--job", "all"],
    ["export", "--features", "features.csv"],
    ["merge", "--out", "merged"],
    ["prune"],
]
COMPUTING = {"numba", "scipy", "joblib", "bearingsim.simulation", "bearingsim.assemble", "bearingsim.core.jit"}
"""Modules that only commands that compute import."""
CODE = f"""
import json, os, sys
from contextlib import redirect_stdout
from bearingsim.cli.app import app
for command, *options in json.loads(sys.argv[1]):
    with redirect_stdout(open(os.devnull, "w")):
        app([command, "small", *options], standalone_mode=False)
    imported = {COMPUTING} & set(sys.modules)
    assert not imported, (command, options, imported)
"""


def test_commands_on_results_do_not_import_the_simulation(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("small.yaml").write_text(STUDY)
    type_("run", "small.yaml", "--quick", "--jobs", 1, "--out", "small")
    command = [sys.executable, "-c", CODE, json.dumps(READING)]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr[-500:]


def test_simulation_imports_scipy_lazily():
    code = "import sys, bearingsim.simulation; print({'scipy.special', 'scipy.optimize'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "set()\n"


def test_warm_compiles_the_models_of_a_study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("small.yaml").write_text(STUDY.replace("[static, ring]", "[static]"))
    assert type_("warm", "small.yaml")[0] == "compiled and in the cache: `static`\n"
    with compilation_callbacks(lambda: pytest.fail("compiled in the run"), lambda: None):
        type_("run", "small.yaml", "--jobs", 1)


def test_the_default_models_are_compiled_on_request(monkeypatch):
    cases = []
    monkeypatch.setattr(simulation, "compile_solvers", lambda requested, on_compile: cases.extend(requested))
    assert type_("warm")[0] == "compiled and in the cache: `rollers`, `planar`\n"
    assert [case.model for case in cases] == ["rollers", "planar", "planar"]
    assert [case.cage and case.cage.motion for case in cases] == [None, "kinematic", "free"]
