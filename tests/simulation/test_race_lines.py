"""The lines of a defect that turns: at BPFI with sidebands of the shaft, at 2 BSF with sidebands of the cage."""

from functools import lru_cache
from math import pi

import numpy as np
import pytest

from bearingsim.simulation.simulate import simulate
from tests.scenes.nf308 import INNER_DEFECT, ROLLER_DEFECT, SLOT, case, light_rollers

FREQUENCY = {"BPFO": 159.0, "BPFI": 231.0, "BPFI+fr": 261.0, "BPFI-fr": 201.0}  # Hz, at 1800 rpm
FREQUENCY |= {"2BSF": 156.9615, "2BSF+FTF": 169.1923, "2BSF-FTF": 144.7308}
OF_THE_INNER_RACE = ("BPFI", "BPFI+fr", "BPFI-fr")
OF_A_ROLLER = ("2BSF", "2BSF+FTF", "2BSF-FTF")
EVERY_10_DEG = np.radians(np.arange(0.0, 181.0, 10.0))


def lines(names, quantity="velocity", **given):
    """Complex amplitudes of the named lines of a case."""
    features = simulate(case(**given)).features
    result = [f"{quantity}@{name}" for name in names]
    return np.array([features[name] * np.exp(1j * features[f"{name}.phase"]) for name in result])


@lru_cache
def healthy():
    """Features of a second of the healthy bearing."""
    return simulate(case(duration="1 s")).features


# What they are made of


def turning(model, **given):
    """Displacement lines of a slot on the inner race and of one on a roller."""
    usual = {"model": model, "settle": "30 ms", "quantity": "displacement"} | given
    usual |= {"step": "16 us"} if model == "static" else {}  # moves its lines by 0.1 %
    inner = lines(OF_THE_INNER_RACE, duration="0.2 s", defect=SLOT | INNER_DEFECT, **usual)
    return inner, lines(OF_A_ROLLER, duration="1 s", defect=SLOT | ROLLER_DEFECT, **usual)


def standing(model):
    """g(phi) (m): displacement line at BPFO of a standing slot, less the healthy one, told from its own place."""
    usual = {"model": model, "duration": "40 ms", "settle": "30 ms", "quantity": "displacement"}
    healthy = lines(["BPFO"], **usual)[0]
    result = [lines(["BPFO"], defect=SLOT | {"angle": float(phi)}, **usual)[0] for phi in EVERY_10_DEG]
    return (np.array(result) - healthy) * np.exp(13j * EVERY_10_DEG)


@pytest.mark.parametrize("model", ["static", "ring"])
def test_a_turning_defects_lines_are_those_of_a_standing_one_all_round(model):
    """A slot of the outer race at phi moves the ring by g(phi) at BPFO; one that turns is met f times a second, at
    angles that turn with it. So its line at f is the mean of g all round, its sidebands the mean of g cos(phi),
    both times f/BPFO: on the inner race at BPFI with the shaft, on a roller (each race once a turn) at 2 BSF with
    the cage.

    Within 3 %. The inner race, being curved the other way, lets the roller sink on 2 % more of the slot's width:
    it hangs free but for sqrt(2 R delta) at either rim, delta = 0.35 um.
    """
    g = standing(model)
    assert np.abs(g.imag).max() < 0.01 * np.abs(g).max()
    once = np.array([0.5, *[1.0] * 17, 0.5]) / 18.0
    all_round, with_cosine = once @ g.real, once @ (g.real * np.cos(EVERY_10_DEG))
    for result, names in zip(turning(model), (OF_THE_INNER_RACE, OF_A_ROLLER), strict=True):
        expected = np.array([all_round, with_cosine, with_cosine]) * FREQUENCY[names[0]] / FREQUENCY["BPFO"]
        assert result == pytest.approx(expected, rel=0.03)


PINNED = {  # um/s, `rollers`, 0.8 mm slot, 150 N, 1 s; less than `ring`'s 5.189 and 2.379 by little
    "inner": {"BPFI": 5.197, "BPFI-fr": 3.863, "BPFI+fr": 5.013, "2BPFI": 10.302},
    "roller": {"2BSF": 2.309, "2BSF-FTF": 1.651, "2BSF+FTF": 1.931, "4BSF": 4.594},
}


def test_lines_of_one_second():
    """Each defect's own lines are there, the other's are not, nor in a healthy bearing."""
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


def test_a_healthy_bearing_has_nothing_there():
    """Its only motion is at the multiples of BPFO, the 0.6 um/s of which leak less than 0.01 um/s, 2 Hz away."""
    for name in (*OF_THE_INNER_RACE, *OF_A_ROLLER, "2BPFI", "4BSF", "FTF", "fr"):
        assert healthy()[f"velocity@{name}"] < 1e-8, name


@pytest.mark.parametrize(
    ("carried", "more", "turned"),
    [
        (INNER_DEFECT, {"angle": 0.3}, {"BPFI": 13 * 0.3, "BPFI+fr": 14 * 0.3, "BPFI-fr": 12 * 0.3}),
        (ROLLER_DEFECT, {"angle": 0.3}, {"2BSF": -0.6, "2BSF+FTF": -0.6, "2BSF-FTF": -0.6, "4BSF": -1.2}),
        (ROLLER_DEFECT, {"roller": 4}, {"2BSF": 0.0, "2BSF+FTF": 6 * pi / 13, "2BSF-FTF": -6 * pi / 13}),
    ],
)
def test_phases_tell_where_a_defect_was_at_the_start(carried, more, turned):
    """``a`` further on, the inner race's slot is met earlier by Z a of its line, a roller's later by 2 a.

    The sidebands add where in the load zone that is: with the shaft's turn, and the cage's to roller 4.
    """
    usual = {"model": "ring", "duration": "1 s", "settle": "30 ms"}
    first, second = (lines(turned, defect=SLOT | carried | changes, **usual) for changes in ({}, more))
    assert np.abs(second / first - np.exp(1j * np.array(list(turned.values())))).max() < 2e-3


@pytest.mark.parametrize("carried", [INNER_DEFECT, ROLLER_DEFECT])
def test_lines_do_not_depend_on_when_one_looks(carried):
    """Their phases count from t = 0, not from the record's start."""
    names = OF_THE_INNER_RACE if carried is INNER_DEFECT else OF_A_ROLLER
    usual = {"model": "ring", "defect": SLOT | carried, "duration": "1 s"}
    first, second = (lines(names, settle=settle, **usual) for settle in ("30 ms", "47.3 ms"))
    assert np.abs(second / first - 1.0).max() < 5e-3


# The ladder of models


@pytest.mark.parametrize(
    ("carried", "names", "duration"),
    [(INNER_DEFECT, OF_THE_INNER_RACE, "0.1 s"), (ROLLER_DEFECT, OF_A_ROLLER[1:], "0.2 s")],
)
@pytest.mark.parametrize("shape", ["rectangular", "circular"])
def test_rollers_without_mass_are_a_ring(carried, names, duration, shape):
    """Rollers of 5 % of their mass, a slot and a bowl over half of the roller: the same lines within 1 %."""
    defect = SLOT | carried | {"shape": shape, "length": "6 mm"}
    usual = {"defect": defect, "duration": duration, "settle": "20 ms"} | light_rollers(0.05)
    ring, rollers = (lines(names, model=model, **usual) for model in ("ring", "rollers"))
    assert np.abs(rollers / ring - 1.0).max() < 0.01


@pytest.mark.parametrize(
    ("carried", "names", "duration"),
    [(INNER_DEFECT, OF_THE_INNER_RACE, "4 s"), (ROLLER_DEFECT, OF_A_ROLLER[2:], "10 s")],
)
def test_slow_rotation_is_static(carried, names, duration):
    """At 30 rpm inertia and damping have nothing to do: displacement lines within 0.1 %."""
    usual = {"speed": "30 rpm", "duration": duration, "settle": "0.5 s", "sampling": "500 Hz"}
    usual |= {"defect": SLOT | carried, "quantity": "displacement"}
    ring = lines(names, model="ring", step="20 us", **usual)
    static = lines(names, model="static", step="200 us", **usual)
    assert np.abs(ring / static - 1.0).max() < 1e-3


def test_small_defects_of_all_elements_add_up():
    """0.05 um deep, one on each race and one on the third roller: less the healthy line the sum of each alone."""
    names = ("BPFO", "2BPFO", *OF_THE_INNER_RACE, *OF_A_ROLLER[1:])
    shallow = SLOT | {"depth": "0.05 um"}
    each = [
        shallow | {"angle": "10 deg"},
        shallow | INNER_DEFECT | {"angle": "70 deg"},
        shallow | ROLLER_DEFECT | {"roller": 3, "angle": "30 deg"},
    ]

    def found(defects):
        usual = {"duration": "0.4 s", "settle": "0 s", "step": "16 us", "sampling": "4000 Hz"}
        return lines(names, quantity="displacement", model="static", defects=defects, **usual)

    healthy = found([])
    alone = [found([one]) - healthy for one in each]
    assert np.abs(found(each) - healthy - sum(alone)) == pytest.approx(0.0, abs=0.01 * np.abs(sum(alone)).min())
    for one, own in zip(alone, ("BPFO", "BPFI", "2BSF+FTF"), strict=True):
        assert np.abs(one[names.index(own)]) > 2e-10
