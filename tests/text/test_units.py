import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim.text.units import (
    DISPLAY,
    EXPECTED,
    UNITS,
    Dimension,
    UnitError,
    display,
    parse,
    show,
    split,
    suggestion,
)


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("0.8 mm", "length", 0.0008),
        ("800 µm", "length", 0.0008),
        ("800 μm", "length", 0.0008),
        (".5mm", "length", 0.0005),
        ("1e-3 m", "length", 0.001),
        ("-20 um", "length", -2e-5),
        ("+5 deg", "angle", math.radians(5)),
        ("5°", "angle", math.radians(5)),
        ("1800 rpm", "rotation", 60 * math.pi),
        ("1800 r/min", "rotation", 60 * math.pi),
        ("30 Hz", "rotation", 60 * math.pi),
        ("360 deg/s", "rotation", 2 * math.pi),
        ("10.24 kHz", "frequency", 10240.0),
        ("2 min", "time", 120.0),
        ("1e4 N/mm", "stiffness", 1e7),
        ("200 N s/m", "damping", 200.0),
        ("200 N*s/m", "damping", 200.0),
        ("200 N.s/m", "damping", 200.0),
        ("200 N·s/m", "damping", 200.0),
        ("200 Ns/m", "damping", 200.0),
        ("0.2 kN.s / m", "damping", 200.0),
        ("100 g.mm", "unbalance", 1e-4),
        ("100 gmm", "unbalance", 1e-4),
        ("0.2 N s/mm", "damping", 200.0),
        ("0.05 s/mm", "inverse velocity", 50.0),
        ("7850 kg/m3", "density", 7850.0),
        ("7.85 g/cm³", "density", 7850.0),
        ("20 mm/s", "velocity", 0.02),
        ("207 GPa", "pressure", 207e9),
        ("1 N/mm²", "pressure", 1e6),
        ("1 N/mm2", "pressure", 1e6),
        ("50 mPa s", "viscosity", 0.05),
        ("0.05 Pas", "viscosity", 0.05),
        ("0.05 Pa·s", "viscosity", 0.05),
        ("100 g mm", "unbalance", 1e-4),
        ("1e-4 kg m", "unbalance", 1e-4),
        ("1e4 N m/rad", "torsional stiffness", 1e4),
        ("1e4 Nm/rad", "torsional stiffness", 1e4),
        ("2 N*mm / rad", "torsional stiffness", 0.002),
        ("0.1 Nm s/rad", "torsional damping", 0.1),
        ("0.1 N·m·s/rad", "torsional damping", 0.1),
        ("0 N", "force", 0.0),
        ("1.5", "number", 1.5),
    ],
)
def test_quantity_becomes_si(text: str, dimension: Dimension, value: float) -> None:
    assert parse(text, dimension) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "dimension", "part", "nearest"),
    [
        ("0,2 mm", "length", "write a decimal point", None),
        ("nan mm", "length", "must be finite", None),
        (".inf mm", "length", "must be finite", None),
        ("1e999999999 m", "length", "too large", None),
        ("1e308 kN", "force", "too large", None),
        ("150", "force", "the unit is missing", None),
        ("150 mm", "force", "`mm` is a unit of length", None),
        ("5 MM", "length", "did you mean `mm`?", "mm"),
        ("1800 rmp", "rotation", "did you mean `rpm`?", "rpm"),
        ("30 rps", "rotation", "did you mean `Hz`?", "Hz"),
        ("30 1/s", "rotation", "did you mean `Hz`?", "Hz"),
        ("1.5.2 mm", "length", "units: m, mm, um, nm", None),
        ("3 N", "number", "no unit here", None),
        ("", "length", "nothing is written", None),
        ("１ mm", "length", "got `１ mm`", None),
        ("1_000 mm", "length", "units: m, mm, um, nm", None),
        ("5 m", "velocity", "`m` is a unit of length", None),
        ("5 N m", "torsional stiffness", "did you mean", "N m/rad"),
    ],
)
def test_invalid_quantity_is_refused(text: str, dimension: Dimension, part: str, nearest: str | None) -> None:
    with pytest.raises(UnitError) as caught:
        parse(text, dimension)
    assert part in str(caught.value)
    assert caught.value.expected == EXPECTED[dimension]
    assert caught.value.nearest == nearest


@given(st.integers(-(10**9), 10**9), st.sampled_from([("m", 0), ("mm", 3), ("um", 6), ("nm", 9)]))
def test_decimal_units_round_once(nanometres: int, unit: tuple[str, int]) -> None:
    word, digits = unit
    shifted = f"{nanometres}e{digits - 9} {word}"
    assert parse(shifted, "length") == float(Fraction(nanometres, 10**9))


@given(st.floats(-1e12, 1e12), st.sampled_from([(d, w) for d, words in UNITS.items() for w in words]))
def test_display_undoes_parse(number: float, unit: tuple[Dimension, str]) -> None:
    dimension, word = unit
    value = parse(f"{number!r} {word}", dimension)
    rounding = 1e-13 if UNITS[dimension][word].zero else 1e-300  # K: of a sum with 273.15 K
    assert display(value, word, dimension) == pytest.approx(number, rel=1e-14, abs=rounding)


def test_a_word_with_two_meanings_needs_its_dimension() -> None:
    assert display(1.0, "Hz", "frequency") == 1.0
    assert display(2 * math.pi, "Hz", "rotation") == 1.0
    with pytest.raises(UnitError, match="one meaning"):
        display(1.0, "Hz")
    with pytest.raises(UnitError, match="unit of length"):
        display(1.0, "rpm", "length")


def test_displayed_quantities() -> None:
    assert show(0.0008, "mm") == "0.8 mm"
    assert split(" 1.50µm ") == ("1.50", "um")


def test_every_dimension_has_a_name_and_an_example() -> None:
    for dimension, words in UNITS.items():
        assert DISPLAY[dimension] in words
        example = EXPECTED[dimension].split("`")[1]
        assert parse(example, dimension) > 0.0


@pytest.mark.parametrize(("text", "dimension"), [("10 MHz", "frequency"), ("1 cm", "length"), ("3 daN", "force")])
def test_an_unknown_prefix_lists_the_units(text, dimension):
    with pytest.raises(UnitError) as refused:
        parse(text, dimension)
    assert refused.value.hint == f"units: {', '.join(UNITS[dimension])}"
    assert refused.value.nearest is None


@pytest.mark.parametrize(
    ("typed", "words", "meant"),
    [
        ("lod", ["load", "model"], "`load`"),
        ("lenght", ["length", "depth"], "`length`"),
        ("rmp", ["rpm", "Hz"], "`rpm`"),
        ("LOAD", ["load"], "`load`"),
        ("velocity@BPF0", ["velocity@BPFI", "velocity@BPFO"], "`velocity@BPFO`"),
        ("velocity@BPF", ["velocity@BPFI", "velocity@BPFO"], "`velocity@BPFI` or `velocity@BPFO`"),
        ("outer_force", ["outer_force.max", "inner_force.max"], "`outer_force.max`"),
        ("N m", ["N m/rad", "N mm/rad"], "`N m/rad`"),
        ("slip", ["step"], ""),
        ("rows", ["rollers", "speed"], ""),
        ("outer_speed", ["speed"], ""),
        ("contact_angle", ["start_angle"], ""),
        ("damping", ["sampling"], ""),
        ("6204", ["6203", "6205"], ""),
        ("2BPFO", ["3BPFO"], ""),
        ("cm", ["mm", "um"], ""),
        ("rms", ["rms_scatter"], ""),
        ("pocket", ["pocket_damping", "pocket_stiffness"], ""),
        ("", ["load"], ""),
    ],
)
def test_only_likely_misspellings_are_suggested(typed: str, words: list[str], meant: str) -> None:
    assert suggestion(typed, words) == (f"did you mean {meant}?" if meant else "")
