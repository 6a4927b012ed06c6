"""Scripts of docs/evidence: all can be imported, and their models have the parameters of the package's."""

import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).parents[2] / "docs/evidence/scripts"
NAMES = sorted((path.stem for path in FOLDER.glob("*.py")), key=lambda name: name != "own_cache")
"""All scripts, ``own_cache`` first, since it must precede the core."""
SCRIPT = f"""
import importlib

for name in {NAMES}:
    importlib.import_module(name)

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.core.models.rollers import Rollers
from touch_down import SCENE, SCENES
from touch_down_models import KNOWN

model = assemble.model(Case.model_validate(SCENE | next(iter(SCENES.values()))))
for kind in KNOWN.values():
    assert Rollers(*kind(*model)) == model, kind
    assert kind._fields == Rollers._fields, kind
"""


def test_scripts_can_be_imported_and_build_their_models(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(FOLDER), prepend=":")
    ended = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
