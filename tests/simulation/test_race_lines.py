"""Lines of a rotating defect: BPFI with sidebands of the shaft, 2 BSF with sidebands of the cage."""

from functools import lru_cache
from math import pi

import numpy as np
import pytest

from bearingsim.simulation.simulate import simulate
from tests.scenes.nf308 import INNER_DEFECT, ROLLER_DEFECT, SLOT, case, light_rollers

FREQUENCY = {"BPFO": 159.0, "BPFI": 231.0, "BPFI+fr": 261.0, "BPFI-fr": 201.0}  # Hz, at 1800 rpm
FREQUENCY |= {"2BSF": 156.9615, "2BSF+FTF": 169.1923, "2BSF-FTF": 144.7308}
INNER_RACE_LINES = ("BPFI", "BPFI+fr", "BPFI-fr")
ROLLER_LINES = ("2BSF", "2BSF+FTF", "2BSF-FTF")
EVERY_10_DEG = np.radians(np.arange(0.0, 181.0, 10.0))


def lines(names, quantity="velocity", **overrides):
    """Return the complex amplitudes of the named lines of a case."""
    features = simulate(case(**overrides)).features
    result = [f"{quantity}@{name}" for name in names]
    return np.array([features[name] * np.exp(1j * features[f"{name}.phase"]) for name in result])


@lru_cache
def healthy():
    """Return the features of 1 s of the healthy bearing."""
    return simulate(case(duration="1 s")).features


# Superposition


def rotating_defect_lines(model, **overrides):
    """Return the displacement lines of a slot on the inner race and of one on a roller."""
    fields = {"model": model, "settle": "30 ms", "quantity": "displacement"} | overrides
    fields |= {"step": "16 us"} if model == "static" else {}  # moves its lines by 0.1 %
    inner = lines(INNER_RACE_LINES, duration="0.2 s", defect=SLOT | INNER_DEFECT, **fields)
    return inner, lines(ROLLER_LINES, duration="1 s", defect=SLOT | ROLLER_DEFECT, **fields)


def fixed_defect_lines(model):
    """Return g(phi) (m), the change of the displacement line at BPFO by a fixed slot, relative to its phase."""
    fields = {"model": model, "duration": "40 ms", "settle": "30 ms", "quantity": "displacement"}
    healthy = lines(["BPFO"], **fields)[0]
    result = [lines(["BPFO"], defect=SLOT | {"angle": float(phi)}, **fields)[0] for phi in EVERY_10_DEG]
    return (np.array(result) - healthy) * np.exp(13j * EVERY_10_DEG)


@pytest.mark.parametrize("model", ["static", "ring"])
def test_lines_of_a_rotating_defect_are_means_over_fixed_positions(model):
    """A slot of the outer race at phi moves the ring by g(phi) at BPFO. A turning slot is met f times a second,
    at angles that turn with it, so its line at f is the mean of g over phi, its sidebands the mean of g cos(phi),
    both times f/BPFO: on the inner race at BPFI with the shaft, on a roller (each race once a turn) at 2 BSF with
    the cage.

    Within 3 %. The inner race, being curved the other way, lets the roller sink over 2 % more of the slot's
    width: all of it except sqrt(2 R delta) at either rim, delta = 0.35 um.
    """
    g = fixed_defect_lines(model)
    assert np.abs(g.imag).max() < 0.01 * np.abs(g).max()
    once = np.array([0.5, *[1.0] * 17, 0.5]) / 18.0
    all_round, with_cosine = once @ g.real, once @ (g.real * np.cos(EVERY_10_DEG))
    for result, names in zip(rotating_defect_lines(model), (INNER_RACE_LINES, ROLLER_LINES), strict=True):
        expected = np.array([all_round, with_cosine, with_cosine]) * FREQUENCY[names[0]] / FREQUENCY["BPFO"]
        assert result == pytest.approx(expected, rel=0.03)


PINNED = {  # um/s, `rollers`, 0.8 mm slot, 150 N, 1 s; less than `ring`'s 5.189 and 2.379 by little
    "inner": {"BPFI": 5.197, "BPFI-fr": 3.863, "BPFI+fr": 5.013, "2BPFI": 10.302},
    "roller": {"2BSF": 2.309, "2BSF-FTF": 1.651, "2BSF+FTF": 1.931, "4BSF": 4.594},
}


def test_lines_of_one_second():
    """Lines of the other defect, or of a healthy bearing, are negligible."""
    for race, expected in PINNED.items():
        result = simulate(case(duration="1 s", defect=SLOT | {"race": race})).features
        for name, value in expected.items():
            assert 1e6 * result[f"velocity@{name}"] == pytest.approx(value, abs=2e-3), name
            assert healthy()[f"velocity@{name}"] < 2e-3 * result[f"velocity@{name}"], name
        for other in set(PINNED) - {race}:
            for name in list(PINNED[other])[:2]:
                assert result[f"velocity@{name}"] < 0.01 * max(expected.values()) * 1e-6, name
        for name in list(expected)[:3]:
            omega = 2 * pi * FREQUENCY[name]
            assert result[f"velocity@{name}"] == pytest.approx(omega * result[f"displacement@{name}"], rel=2e-3)
            assert result[f"acceleration@{name}"] == pytest.approx(omega * result[f"velocity@{name}"], rel=2e-6)


def test_healthy_bearing_has_no_lines_of_rotating_defects():
    """It moves at multiples of BPFO only, whose 0.6 um/s leak less than 0.01 um/s at 2 Hz distance."""
    for name in (*INNER_RACE_LINES, *ROLLER_LINES, "2BPFI", "4BSF", "FTF", "fr"):
        assert healthy()[f"velocity@{name}"] < 1e-8, name


@pytest.mark.parametrize(
    ("race_fields", "moved", "phases"),
    [
        (INNER_DEFECT, {"angle": 0.3}, {"BPFI": 13 * 0.3, "BPFI+fr": 14 * 0.3, "BPFI-fr": 12 * 0.3}),
        (ROLLER_DEFECT, {"angle": 0.3}, {"2BSF": -0.6, "2BSF+FTF": -0.6, "2BSF-FTF": -0.6, "4BSF": -1.2}),
        (ROLLER_DEFECT, {"roller": 4}, {"2BSF": 0.0, "2BSF+FTF": 6 * pi / 13, "2BSF-FTF": -6 * pi / 13}),
    ],
)
def test_phases_depend_on_the_initial_position_of_the_defect(race_fields, moved, phases):
    """A shift of the defect by ``a`` advances the phase of BPFI by Z a and delays that of 2 BSF by 2 a.

    The phases of sidebands also depend on the angle of the shaft, or on that of the cage at roller 4.
    """
    fields = {"model": "ring", "duration": "1 s", "settle": "30 ms"}
    first, second = (lines(phases, defect=SLOT | race_fields | changes, **fields) for changes in ({}, moved))
    assert np.abs(second / first - np.exp(1j * np.array(list(phases.values())))).max() < 2e-3


@pytest.mark.parametrize("race_fields", [INNER_DEFECT, ROLLER_DEFECT])
def test_lines_do_not_depend_on_the_start_of_the_record(race_fields):
    """Phases refer to t = 0."""
    names = INNER_RACE_LINES if race_fields is INNER_DEFECT else ROLLER_LINES
    fields = {"model": "ring", "defect": SLOT | race_fields, "duration": "1 s"}
    first, second = (lines(names, settle=settle, **fields) for settle in ("30 ms", "47.3 ms"))
    assert np.abs(second / first - 1.0).max() < 5e-3


# The ladder of models


@pytest.mark.parametrize(
    ("race_fields", "names", "duration"),
    [(INNER_DEFECT, INNER_RACE_LINES, "0.1 s"), (ROLLER_DEFECT, ROLLER_LINES[1:], "0.2 s")],
)
@pytest.mark.parametrize("shape", ["rectangular", "circular"])
def test_light_rollers_agree_with_ring(race_fields, names, duration, shape):
    """With 5 % of the mass, a slot and a bowl over half of the roller: within 1 %."""
    defect = SLOT | race_fields | {"shape": shape, "length": "6 mm"}
    fields = {"defect": defect, "duration": duration, "settle": "20 ms"} | light_rollers(0.05)
    ring, rollers = (lines(names, model=model, **fields) for model in ("ring", "rollers"))
    assert np.abs(rollers / ring - 1.0).max() < 0.01


@pytest.mark.parametrize(
    ("race_fields", "names", "duration"),
    [(INNER_DEFECT, INNER_RACE_LINES, "4 s"), (ROLLER_DEFECT, ROLLER_LINES[2:], "10 s")],
)
def test_ring_at_low_speed_agrees_with_static(race_fields, names, duration):
    """At 30 rpm inertia and damping are negligible: displacement lines within 0.1 %."""
    fields = {"speed": "30 rpm", "duration": duration, "settle": "0.5 s", "sampling": "500 Hz"}
    fields |= {"defect": SLOT | race_fields, "quantity": "displacement"}
    ring = lines(names, model="ring", step="20 us", **fields)
    static = lines(names, model="static", step="200 us", **fields)
    assert np.abs(ring / static - 1.0).max() < 1e-3


def test_lines_of_small_defects_add_up():
    """One of 0.05 um on each race and on the third roller: the sum of the changes by each one."""
    names = ("BPFO", "2BPFO", *INNER_RACE_LINES, *ROLLER_LINES[1:])
    shallow = SLOT | {"depth": "0.05 um"}
    each = [
        shallow | {"angle": "10 deg"},
        shallow | INNER_DEFECT | {"angle": "70 deg"},
        shallow | ROLLER_DEFECT | {"roller": 3, "angle": "30 deg"},
    ]

    def displacement_lines(defects):
        fields = {"duration": "0.4 s", "settle": "0 s", "step": "8 us", "sampling": "4000 Hz"}
        return lines(names, quantity="displacement", model="static", defects=defects, **fields)

    healthy = displacement_lines([])
    changes = [displacement_lines([defect]) - healthy for defect in each]
    assert np.abs(displacement_lines(each) - healthy - sum(changes)) == pytest.approx(
        0.0, abs=0.01 * np.abs(sum(changes)).min()
    )
    for change, own in zip(changes, ("BPFO", "BPFI", "2BSF+FTF"), strict=True):
        assert np.abs(change[names.index(own)]) > 2e-10
