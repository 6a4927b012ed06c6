"""Trends of `spatial`: the lines of `rollers` if no roller tilts, and the effect of tilt."""

from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from bearingsim.config import Case
from bearingsim.config.rules.completion import slice_ends
from bearingsim.simulation.record import Record
from bearingsim.simulation.simulate import simulate

SLOT = {"shape": "rectangular", "width": "0.8 mm", "depth": "50 um"}
SHORT: dict[str, Any] = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "step_check": False}
SHORT |= {"duration": "20 ms", "settle": "12 ms", "contact": {"slices": 8}}
LEAN = ["roller.10.tilt", "roller.10.outer_line_load", "roller.10.outer_force"]  # it crosses the defect at 22 ms


@lru_cache
def run(model: str, length: float, offset: float = 0.0) -> Record:
    return simulate(case(model, length, offset))


def case(model: str, length: float, offset: float) -> Case:
    defect: dict[str, Any] = SLOT | {"length": length * 1e-3, "offset": offset * 1e-3}
    record = LEAN if model == "spatial" else []
    return Case.model_validate(SHORT | {"model": model, "defect": defect, "record": record})


def line(model: str, length: float, offset: float = 0.0) -> float:
    return run(model, length, offset).features["velocity@BPFO"]


def test_amplitude_increases_with_defect_length_in_rollers_and_spatial() -> None:
    lengths = (3.0, 6.0, 9.0, 12.0)
    flat, sliced = ([line(model, length) for length in lengths] for model in ("rollers", "spatial"))
    assert np.all(np.diff(flat) > 0.0)
    assert np.all(np.diff(sliced) > 0.0)
    assert sliced == pytest.approx(flat, rel=0.02)  # planar and spatial roll with friction, rollers without


def test_spatial_agrees_with_planar_without_tilt() -> None:
    """At a short step, because Verlet divides steps at touch-downs of whole rollers only."""
    spatial, planar = (
        simulate(case(model, 12.0, 0.0).model_copy(update={"step": 2e-7})).features["velocity@BPFO"]
        for model in ("spatial", "planar")
    )
    assert spatial == pytest.approx(planar, rel=1e-3)
    assert np.abs(run("spatial", 12.0).series["roller.10.tilt"]).max() < 1e-12


def test_off_centre_defect_tilts_roller_and_raises_amplitude() -> None:
    centred, aside = line("spatial", 3.0), line("spatial", 3.0, 4.0)
    assert line("rollers", 3.0, 4.0) == line("rollers", 3.0)  # knows no tilt
    assert aside > 1.03 * centred
    tilt = run("spatial", 3.0, 4.0).series["roller.10.tilt"]
    mirrored = run("spatial", 3.0, -4.0).series["roller.10.tilt"]
    assert tilt.max() > 3e-6  # its +z end falls outwards, into the defect
    assert abs(tilt.min()) < tilt.max()
    assert mirrored.min() == pytest.approx(-tilt.max(), rel=0.02)
    assert line("spatial", 3.0, -4.0) == pytest.approx(aside, rel=1e-3)


def test_the_line_load_adds_up_to_the_force() -> None:
    result = run("spatial", 3.0, 4.0)
    loads = [name for name in result.series if "outer_line_load" in name]
    widths = np.diff(slice_ends(case("spatial", 3.0, 4.0)))
    total = sum(result.series[f"roller.10.outer_line_load.{k + 1}"] * width for k, width in enumerate(widths))
    assert len(loads) == len(widths)
    assert total == pytest.approx(result.series["roller.10.outer_force"], rel=1e-6, abs=1e-6)


def test_no_flange_wedges_misaligned_rollers_with_a_kinematic_cage() -> None:
    """At 1 mrad the inner flanges run out by more than their play of 25 um. Rollers take up half of the lean, and
    16 ms later the fourth has the static force of its new angle."""
    turned = 0.016 * 60.0 * np.pi * (1.0 - 12.0 / 65.0) / 2.0
    fields = SHORT | {"model": "spatial", "load": "1 kN", "settle": "0 s", "cage": {"motion": "kinematic"}}
    fields |= {"misalignment": {"inner": "1 mrad", "direction": 0.4}, "record": ["roller.4.outer_force"]}
    later, start = (
        simulate(Case.model_validate(fields | {"start_angle": angle, "sampling": "10 kHz"}))
        for angle in (0.2, 0.2 + turned)
    )
    force, static = later.series["roller.4.outer_force"][160], start.series["roller.4.outer_force"][0]
    assert static == pytest.approx(80.0, rel=0.1)
    assert force == pytest.approx(static, rel=0.03)
    assert later.features["tilt.max"] == pytest.approx(0.5e-3, rel=0.02)
