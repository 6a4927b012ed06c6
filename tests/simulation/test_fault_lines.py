"""Frequencies of defect lines, found in the recorded velocity by the picker without a model."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from bearingsim.signals import PickedLine, pick_line
from bearingsim.simulation.record import Record
from bearingsim.simulation.simulate import simulate
from tests.scenes.nf308 import SLOT, case

BPFO, BPFI, TWICE_BSF, FTF, SHAFT = 159.0, 231.0, 156.9615385, 12.2307692, 30.0  # Hz: NF308 at 1800 rpm
FS = 10240.0
SCENES: dict[str, dict[str, Any]] = {
    "inner": {"defect": SLOT | {"race": "inner"}},
    "roller": {"defect": SLOT | {"race": "roller"}},
    "roller-and-outer": {"defects": [SLOT | {"race": "roller"}, SLOT | {"width": "0.3 mm", "angle": "10 deg"}]},
}


@cache
def record(name: str, seconds: float = 2.0) -> Record:
    """2 s of a scene in `ring`: a Hann window, under which features are read, leaks 0.5 % of 2 BSF into BPFO."""
    return simulate(case(model="ring", duration=seconds, **SCENES[name]))


def picked(name: str, hertz: float) -> PickedLine | None:
    """Return the line of the ring's velocity within 0.5 % of a frequency."""
    return pick_line(record(name).velocity[:, 0], FS, hertz)


@pytest.mark.parametrize(
    ("name", "line", "sideband"), [("inner", BPFI, SHAFT), ("roller", TWICE_BSF, FTF)], ids=["inner", "roller"]
)
def test_a_rotating_defect_has_its_line_and_sidebands(name: str, line: float, sideband: float) -> None:
    """BPFI with sidebands of the shaft, 2 BSF with sidebands of the cage, far above the surrounding spectrum."""
    for hertz in (line, line - sideband, line + sideband):
        result = picked(name, hertz)
        assert result is not None, hertz
        assert result.frequency == pytest.approx(hertz, rel=5e-4)
        assert result.median_ratio > 10.0


def test_a_defect_on_a_roller_has_no_line_at_the_outer_race_frequency() -> None:
    """2 BSF is 1.3 % below BPFO: its shoulder is not taken for a line. What is there is variable compliance."""
    result, line = picked("roller", BPFO), picked("roller", TWICE_BSF)
    assert line is not None
    assert result is None or result.amplitude < 0.3 * line.amplitude


def test_2bsf_and_bpfo_are_resolved_in_one_second() -> None:
    """They are 2.04 Hz apart."""
    velocity = record("roller-and-outer", 1.0).velocity[:, 0]
    of_roller, of_race = pick_line(velocity, FS, TWICE_BSF), pick_line(velocity, FS, BPFO)
    assert of_roller is not None
    assert of_race is not None
    assert of_roller.frequency == pytest.approx(TWICE_BSF, rel=5e-4)
    assert of_race.frequency == pytest.approx(BPFO, rel=5e-4)


@pytest.mark.parametrize("name", SCENES)
def test_picked_lines_agree_with_features(name: str) -> None:
    """Within 2 %: from the samples alone, and from fine samples at known angles."""
    hertz = {"BPFO": BPFO, "BPFI": BPFI, "2BSF": TWICE_BSF, "BPFI+fr": BPFI + SHAFT, "2BSF+FTF": TWICE_BSF + FTF}
    strong = {line: record(name).features[f"velocity@{line}"] for line in hertz}
    largest = max(strong.values())
    compared = [line for line, amplitude in strong.items() if amplitude > 0.2 * largest]
    assert compared
    for line in compared:
        result = picked(name, hertz[line])
        assert result is not None, line
        assert result.amplitude == pytest.approx(strong[line], rel=0.02)


def test_the_statement_of_frequencies_is_the_geometry() -> None:
    gamma = 12.0 / 65.0
    assert np.array([BPFO, BPFI, TWICE_BSF, FTF]) == pytest.approx(
        [195.0 * (1 - gamma), 195.0 * (1 + gamma), 30.0 * (1 - gamma**2) / gamma, 15.0 * (1 - gamma)], rel=1e-6
    )
