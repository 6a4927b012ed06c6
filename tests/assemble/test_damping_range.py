"""c/k of the contacts that are built: in the plausible range by default and of a film, far beyond it with chi.

c/k is dQ/dv over dQ/d(delta) of a contact at rest. Loads are shares of that at which the largest pressure is the
one of the static load rating, 4.0 GPa of rollers and 4.2 GPa of balls.
"""

from math import pi
from typing import Any

import numpy as np
import pytest

from bearingsim.assemble import contacts
from bearingsim.assemble.scales import approach
from bearingsim.config import Case, library_names
from bearingsim.config.rules.damping import PLAUSIBLE, Damped
from bearingsim.core.laws.damping.interface import derivatives
from bearingsim.simulation import choice
from benchmarks.impact_force import static_load_of_element
from tests.scenes.nf308 import CHI

BEARINGS = library_names("bearings")
SHARES = np.geomspace(1e-3, 0.5, 25)
US = 1e-6


def case(bearing: str, damping: Any, rpm: float = 1800.0, **more: Any) -> Case:
    base = {"bearing": bearing, "speed": rpm * pi / 30.0, "load": 100.0, "model": "rollers"}
    return Case.model_validate(base | {"contact": {"damping": damping}} | more)


def at_shares(given: Case, on_outer: bool, shares: np.ndarray = SHARES) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness (N/m) and damping (N s/m) of one contact at shares of its static load."""
    law, Q = contacts.contact_law(given, on_outer), static_load_of_element(given, on_outer)
    found = np.array([derivatives(law, approach(law, share * Q), 0.0) for share in shares])
    return found[:, 0], found[:, 1]


def times(given: Case, on_outer: bool) -> np.ndarray:
    """c/k (s)."""
    k, c = at_shares(given, on_outer)
    return c / k


@pytest.mark.parametrize("on_outer", [True, False], ids=["outer", "inner"])
@pytest.mark.parametrize("bearing", BEARINGS)
def test_the_default_is_plausible_at_every_load(bearing: str, on_outer: bool) -> None:
    found = times(case(bearing, "kraemer"), on_outer)
    assert found == pytest.approx(2.5 * US, rel=1e-9)
    assert PLAUSIBLE[0] <= found.min() <= found.max() <= PLAUSIBLE[1]


CHI_AT_A_TENTH = {
    "6203": (249, 182),
    "6205": (287, 222),
    "6309": (646, 469),
    "nf308": (392, 280),
    "nf308-catalogue": (391, 280),
    "nu204": (252, 169),
    "nu205": (247, 174),
    "nu206": (295, 207),
    "nu209": (317, 240),
    "nu210": (351, 265),
}
"""c/k (us) with chi = 50 s/m at a tenth of the static load, outer and inner race: 7 to 26 times the plausible."""


@pytest.mark.parametrize("bearing", BEARINGS)
def test_chi_is_far_from_plausible(bearing: str) -> None:
    """It grows with the approach: at 1e-3 of the static load 2.7 to 30 us, at half of it over 500 us."""
    given, known = case(bearing, CHI), CHI_AT_A_TENTH[bearing]
    for on_outer, expected in zip((True, False), known, strict=True):
        k, c = at_shares(given, on_outer, np.array([0.1]))
        assert c[0] / k[0] / US == pytest.approx(expected, abs=0.6)
        found = times(given, on_outer)
        assert found.max() > 500.0 * US
        assert 2.5 * US < found.min() < 31.0 * US
        assert (np.diff(found) > 0.0).all()


OILS = [(rpm, viscosity) for rpm in (300.0, 1800.0, 6000.0) for viscosity in (0.01, 0.03, 0.06)]


@pytest.mark.parametrize("bearing", BEARINGS)
def test_a_film_is_plausible_at_every_load_speed_and_viscosity(bearing: str) -> None:
    """300 to 6000 rpm, 10 to 60 mPa s: 0.17 to 38 us; c does not grow with load from 10 to 50 %.

    But for one: inner race of the 6309, 6000 rpm, 10 mPa s: there it is 1.6 % more at 50 % than at 10 %.
    """
    heavy = np.geomspace(0.1, 0.5, 9)
    for rpm, viscosity in OILS:
        given = case(bearing, {"law": "film", "viscosity": viscosity}, rpm)
        for on_outer in (True, False):
            found = times(given, on_outer)
            assert found.min() > 0.1 * US, (rpm, viscosity, on_outer)
            assert found.max() < 50.0 * US, (rpm, viscosity, on_outer)
            _, c = at_shares(given, on_outer, heavy)
            assert (c[1:] < 1.004 * c[:-1]).all(), (rpm, viscosity, on_outer)
            allowed = 1.02 if (bearing, on_outer, rpm, viscosity) == ("6309", False, 6000.0, 0.01) else 1.0
            assert c[-1] < allowed * c[0], (rpm, viscosity, on_outer)


def test_a_loss_factor_is_a_time() -> None:
    """1.5 % at 10 kHz: 0.24 us, of dry steel, and said to be too light."""
    given = case("nf308", {"law": "loss-factor", "loss_factor": "1.5 %", "frequency": "10 kHz"})
    found = times(given, on_outer=True)
    assert found == pytest.approx(0.015 / (2.0 * pi * 1e4), rel=1e-9)
    assert Damped(float(found.max()), 0.01).too_light


# What is said of it


ELEVEN = [
    ("nf308", 150.0, 1800.0, 7.9),
    ("nf308", 300.0, 1800.0, 14.5),
    ("nu205", 100.0, 1800.0, 7.5),
    ("nu205", 2700.0, 1800.0, 145.0),
    ("nu210", 300.0, 1800.0, 12.9),
    ("nu210", 13900.0, 1800.0, 398.0),
    ("nu210", 13900.0, 600.0, 398.0),
    ("6205", 100.0, 1800.0, 54.0),
    ("6205", 1400.0, 1800.0, 314.0),
    ("6309", 300.0, 1800.0, 95.0),
    ("6309", 5300.0, 1800.0, 630.0),
]
"""Bearing, load (N), speed (rpm), and c/k (us) of chi = 50 s/m, of scenes with a slot of 0.8 mm and 50 um."""


def damped(bearing: str, load: float, rpm: float, damping: Any) -> Damped:
    length = case(bearing, damping).bearing.roller_length or 8e-3
    slot = {"shape": "rectangular", "width": "0.8 mm", "depth": "50 um", "length": length}
    found = choice.limits(case(bearing, damping, rpm, load=load, defect=slot))
    return Damped(found.damping_time, found.damping_ratio, found.crossing)


def test_seven_of_eleven_scenes_are_too_heavily_damped_by_chi_and_none_by_default() -> None:
    heavy = [damped(*scene[:3], CHI) for scene in ELEVEN]
    assert [one.time / US for one in heavy] == pytest.approx([scene[3] for scene in ELEVEN], rel=0.02)
    assert [one.too_heavy for one in heavy] == [time > 50.0 for *_, time in ELEVEN]
    assert sum(one.too_heavy for one in heavy) == 7
    usual = [damped(*scene[:3], "kraemer") for scene in ELEVEN]
    assert not any(one.too_heavy or one.too_light for one in usual)
    assert all(one.time == pytest.approx(2.5 * US, rel=1e-9) for one in usual)


def test_what_is_crossed_fast_may_be_damped_less() -> None:
    assert not Damped(25.0 * US, 1.0).too_heavy  # the end of the range itself
    assert Damped(25.1 * US, 1.0).too_heavy
    assert Damped(3.0 * US, 1.0, crossing=29.0 * US).too_heavy
    assert not Damped(3.0 * US, 1.0, crossing=31.0 * US).too_heavy
    assert Damped(0.29 * US, 0.01).too_light
    assert not Damped(0.3 * US, 0.01).too_light
