"""Formulas: values, units, and refusals with their positions."""

import math
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim.study.paths import dimension, known_paths
from bearingsim.text.algebra import BOOLEAN, DIMENSIONLESS, MAX_CHARACTERS, Kind, kind_of, kind_text
from bearingsim.text.expressions import ExpressionError, read
from bearingsim.text.units import UNITS, Dimension, parse
from bearingsim.text.yamlfile import Mark, Node

VALUES = {"load": 150.0, "defect.width": 0.0008, "defects.2.width": 0.002, "speed": 188.5, "seed": 3.0}
WARM = "contact.damping.temperature"
VALUES[WARM] = 328.15  # 55 C


def node(text: str, before: str = "  - ") -> Node:
    return Node(text, Mark("f", 3, len(before) + 1, before + text))


def kind(path: str) -> Kind:
    if path not in VALUES:
        raise ValueError(f"no such path `{path}`")
    si_dimension = dimension(path)
    return kind_of(si_dimension) if si_dimension else DIMENSIONLESS


def value(text: str, values: dict[str, float] = VALUES) -> tuple[float, str]:
    """Value of a formula, and its kind."""
    result = read(node(text))
    what = kind_text(result.kind(kind))
    return result.value(values.__getitem__), what


def refusal(text: str) -> tuple[str, str]:
    """Message, and text at the caret."""
    with pytest.raises(ExpressionError) as caught:
        value(text)
    return str(caught.value), caught.value.mark.source_line[caught.value.mark.column - 1 :]


@pytest.mark.parametrize(
    ("text", "expected", "what"),
    [
        ("defect.width / 4", 0.0002, "a length"),
        ("defects.2.width - defect.width", 0.0012, "a length"),
        ("2 * 3 mm", 0.006, "a length"),
        ("2 * 3mm", 0.006, "a length"),
        ("-3 um + 1 mm", 0.000997, "a length"),
        ("3 µm", 3e-6, "a length"),
        ("load / 1e8 N/m", 1.5e-6, "a length"),
        ("load/defect.width", 187500.0, "a stiffness"),
        ("3 N / defect.width", 3750.0, "a stiffness"),
        ("sqrt(2 mm * 8 mm)", 0.004, "a length"),
        ("(2 mm) ** 2", 4e-6, "in m^2"),
        ("2 * (1 mm)**2", 2e-6, "in m^2"),
        ("defect.width**2", 0.0008**2, "in m^2"),
        ("(4 N) ** (1/2)", 2.0, "in m^1/2 kg^1/2 s^-1"),
        ("min(load, 100 N, 1 kN)", 100.0, "a force"),
        ("max(2, 3) * abs(-2)", 6.0, "a plain number"),
        ("pi * 2", 2.0 * math.pi, "a plain number"),
        ("50 %", 0.5, "a plain number"),
        ("90 deg", math.pi / 2.0, "an angle"),
        ("90 °", math.pi / 2.0, "an angle"),
        ("60 rpm / 2", math.pi, "a rotation speed"),
        ("30 Hz", 30.0, "a frequency"),
        ("20 1/GPa", 2e-8, "a pressure coefficient of viscosity"),
        ("200 N s/m", 200.0, "a damping coefficient"),
        ("7.8 g/cm^3", 7800.0, "a density"),
        ("seed + 1", 4.0, "a plain number"),
        (" load ", 150.0, "a force"),
        ("2 ** 3 ** 2", 512.0, "a plain number"),
        ("load < 200 N", True, "true or false"),
        ("100 N < load <= 150 N", True, "true or false"),
        ("not load > 1 N or defect.width > 1 mm", False, "true or false"),
        ("seed == 0 or 1 / seed > 1", False, "true or false"),
    ],
)  # fmt: skip
def test_values_of_formulas(text: str, expected: float, what: str) -> None:
    result, found_kind = value(text)
    assert result == pytest.approx(expected, rel=1e-14)
    assert found_kind == what


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("3 mm**2", "write `(3 mm)**2` or `3 * (1 mm)**2`"),
        ("-3 mm**2", "write `(3 mm)**2` or `3 * (1 mm)**2`"),
        ("(load * 3 mm ** 2)", "write `(3 mm)**2` or `3 * (1 mm)**2`"),
        ("5 %**2", "write `(5 %)**2` or `5 * (1 %)**2`"),
        ("2 N/mm**2", "write `(2 N/mm)**2` or `2 N/mm^2`"),
        ("2 N/m ** 2", "write `(2 N/m)**2` or `2 N/m^2`"),
        ("4 mm**(1/2)", "write `(4 mm)**(...)` or `4 * (1 mm)**(...)`"),
    ],
)
def test_power_of_a_quantity_needs_brackets(text: str, remedy: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        value(text)
    assert caught.value.hint == remedy
    first_line, pointed = refusal(text)
    assert first_line.startswith("a power of `")
    assert first_line.endswith("` without brackets")
    assert pointed.startswith("**")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.1 * 3 == 0.3", True),
        ("0.1 * 3 != 0.3", False),
        ("0.1 * 3 <= 0.3", True),
        ("0.1 * 3 > 0.3", False),
        ("0.3 >= 0.1 * 3", True),
        ("0.3 < 0.1 * 3", False),
        ("10 um * 3 == 30 um", True),
        ("1.00000000001 == 1", False),
        ("1.00000000001 > 1", True),
        ("0.99999999999 < 1", True),
        ("1 um - 1 um == 0 um", True),
        ("1e-300 > 0", True),
        ("0.1 * 3 - 0.3 == 0", False),
        ("1 < 1 + 1e-13 < 2", False),
    ],
)
def test_values_that_differ_in_the_last_bits_are_equal(text: str, expected: bool) -> None:
    assert value(text)[0] is expected


NEAR = st.floats(-1e3, 1e3).flatmap(
    lambda a: st.tuples(
        st.just(a), st.floats(-3e-12, 3e-12).map(lambda share: a * (1.0 + share)) | st.floats(-1e3, 1e3)
    )
)


@given(NEAR)
def test_exactly_one_of_less_equal_and_greater_is_true(pair: tuple[float, float]) -> None:
    names = dict(zip(("a.x", "b"), pair, strict=True))
    holds = {}
    for sign in ("<", "<=", ">", ">=", "==", "!="):
        result = read(Node(f"a.x {sign} b", Mark("f")))
        result.kind(lambda _: DIMENSIONLESS)
        holds[sign] = bool(result.value(names.__getitem__))
    assert holds["<"] + holds["=="] + holds[">"] == 1
    assert [holds["<="], holds[">="], holds["!="]] == [not holds[">"], not holds["<"], not holds["=="]]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"{WARM} > -5 C", True),
        (f"{WARM} > -5 degC", True),
        (f"{WARM} < -5 C", False),
        (f"{WARM} > - 60 C", True),
        (f"{WARM} > +60 C", False),
        (f"{WARM} == 55 C", True),
        (f"50 C < {WARM} < --60 C", True),
        (f"{WARM} + 10 K > 60 C", True),
        (f"{WARM} - 293.15 K > 30 K", True),
        ("-5 C", 268.15),
        ("-(5 C)", 268.15),
        (f"min({WARM}, 60 C) + 10 K", 338.15),
        (f"max({WARM}, -5 C, 60 C)", 333.15),
        (f"{WARM} * 2", 656.3),
        ("-5 K", -5.0),
    ],
)
def test_temperatures(text: str, expected: float) -> None:
    assert value(text)[0] == pytest.approx(expected, rel=1e-14)


def test_temperatures_below_zero_are_compared() -> None:
    """-10 C is not above -5 C, and -2 C is."""
    assert value(f"{WARM} > -5 C", {WARM: 263.15})[0] is False
    assert value(f"{WARM} > -5 C", {WARM: 271.15})[0] is True


@pytest.mark.parametrize(
    ("text", "message", "caret"),
    [
        ("20 C + 10 C", "a sum with degrees Celsius", "20 C +"),
        (f"{WARM} + 20 C", "a sum with degrees Celsius", "20 C"),
        (f"({WARM} - 20 degC) > 30 C", "a difference with degrees Celsius", "20 degC)"),
        ("2 * 20 C", "a product with degrees Celsius", "20 C"),
        (f"{WARM} / 20 C", "a quotient with degrees Celsius", "20 C"),
        ("(20 C) ** 2", "a power with degrees Celsius", "20 C)"),
        ("abs(20 C)", "a function of degrees Celsius", "20 C)"),
        ("sqrt(20 C)", "a function of degrees Celsius", "20 C)"),
        (f"{WARM} - 280 K > 20 C", "degrees Celsius and a temperature difference", "20 C"),
        (f"20 C > abs({WARM} - 280 K)", "degrees Celsius and a temperature difference", "20 C"),
        (f"max({WARM} - 280 K, 20 C)", "degrees Celsius and a temperature difference", "20 C"),
    ],
)
def test_arithmetic_with_degrees_celsius_is_refused(text: str, message: str, caret: str) -> None:
    first_line, pointed = refusal(text)
    assert first_line == message
    assert pointed.startswith(caret)


@pytest.mark.parametrize(("degrees", "kelvins"), [("20", "293.15"), ("-20", "253.15"), ("0.5", "273.65")])
def test_the_remedy_for_degrees_celsius(degrees: str, kelvins: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        value(f"2 * {degrees} C")
    assert caught.value.hint == f"write `{degrees} K` for a difference, `{kelvins} K` for a temperature"


def test_conditions_are_evaluated_only_as_far_as_needed() -> None:
    """As in Python: a condition before a division prevents it."""
    assert value("seed == 0 or 1 / seed > 1", {"seed": 0.0})[0] is True
    assert value("seed != 0 and 1 / seed > 1", {"seed": 0.0})[0] is False
    assert value("1 < seed < 1 / seed", {"seed": 0.0})[0] is False


@pytest.mark.parametrize(
    ("text", "message", "caret"),
    [
        ("load / (2 - 2)", "a division by zero", "/ (2"),
        ("0 ** -1", "a division by zero", "** -1"),
        ("(load)  / 0", "a division by zero", "/ 0"),
        ("10**10**10", "the number is too large", "**10"),
        ("1e308 * 10", "the number is too large", "* 10"),
        ("1e999", "the number is too large", "1e999"),
        ("1e999 N < load", "the number is too large", "1e999 N"),
        ("2 * 1e999 C", "the number is too large", "1e999 C"),
        ("1" * 101 + " N", "more than 100 digits", "1" * 101),
        ("9" * 350, "the number is too large", "9" * 350),
        ("sqrt(2 - 3)", "a root of less than zero", "sqrt"),
        ("(2 - 3) ** 0.5", "a root of less than zero", "** 0.5"),
        ("load + 3 mm", "expected a force as on the left, got a length", "3 mm"),
        ("min(load, 3)", "expected a force as on the left, got a plain number", "3)"),
        ("2 < 3 < load", "expected a plain number as on the left, got a force", "load"),
        ("speed < 30 Hz", "expected a rotation speed as on the left, got a frequency", "30 Hz"),
        ("2 ** load", "an exponent is a plain number, got a force", "load"),
        ("load ** seed", "the exponent of a force must be written as a number", "seed"),
        ("load ** 11", "the exponent of a force is at most 10", "11"),
        ("load and 1 < 2", "expected a comparison such as `load < 200 N`, got a force", "load"),
        ("1 < 2 and load", "expected a comparison such as `load < 200 N`, got a force", "load"),
        ("not load", "expected a comparison such as `load < 200 N`, got a force", "load"),
        ("1 + (1 < 2)", "expected a number, got true or false", "1 < 2"),
        ("(1 < 2) < 3", "expected a number, got true or false", "1 < 2"),
        ("-(1 < 2)", "expected a number, got true or false", "1 < 2"),
        ("abs(1 < 2)", "expected a number, got true or false", "1 < 2"),
        ("defect.widt / 4", "no such path `defect.widt`", "defect.widt"),
        ("2 * lod", "no such path `lod`", "lod"),
        ("2 * GPa", "no such path `GPa`", "GPa"),
        ("201/GPa", "no such path `GPa`", "GPa"),
        ("sqr(4)", "no function `sqr`", "sqr(4)"),
        ("min", "`min` has no argument", "min"),
        ("min(1)", "expected two values or more, got 1", "min(1)"),
        ("sqrt(1, 2)", "expected one value, got 2", "sqrt"),
        ("3 foo", "not a valid formula", "foo"),
        ("5 m^2", "not a valid formula", "m^2"),
        ("1 +", "not a valid formula", "+"),
        ("1) + (2", "not a valid formula", ") + (2"),
        ("2 × 3", "a character that is not allowed in formulas: '\\xd7'", "× 3"),
        ("", "expected a formula such as `defect.width / 4`", ""),
        ("1" + " " * MAX_CHARACTERS, f"more than {MAX_CHARACTERS} characters in a formula", "1"),
    ],
)  # fmt: skip
def test_invalid_entry_is_refused_at_its_position(text: str, message: str, caret: str) -> None:
    first_line, pointed = refusal(text)
    assert first_line == message
    assert pointed.startswith(caret)


HOSTILE = [
    "__import__('os').system('true')", "().__class__.__bases__[0]", "load.__class__", "[1][0]", "{1: 2}",
    "'a' * 9",
    "(lambda: 1)()", "[x for x in (1,)]", "1 if 1 < 2 else 2", "f'{load}'", "True", "None", "...", "1j", "b'a'",
    "(x := 3)", "x := 3", "*load", "min(*[1, 2])", "min(1, 2, key=abs)", "7 % 2", "7 // 2", "1 << 99", "~1",
    "1 in [1]", "1 is 1", "3 @ 4", "await load", "yield 1", "min.__call__(1, 2)", "open('x')", "print(1)",
    "abs.__self__", "load[0]", "1; 2", "import os", "-" * 399 + "1", "(" * 200 + "1" + ")" * 199,
    "+".join("1" * 200),
    "1if 2else 3", "not " * 99 + "1", "\x00", "1\x002", "9**9**9**9", "_" * 20, "((((1)(1))(1))(1))",
]  # fmt: skip


@pytest.mark.parametrize("text", HOSTILE)
def test_python_code_is_refused(text: str) -> None:
    before = set(sys.modules)
    refusal(text)
    assert "os.system" not in set(sys.modules) - before


def test_a_formula_opens_no_file(tmp_path: Path) -> None:
    refusal(f"open('{tmp_path}/x', 'w')")
    assert not list(tmp_path.iterdir())


@given(st.text(alphabet="0123456789.+-*/()<>=! ,abdefhilmnopqrstwxy_°µ'[]{}:^%@", max_size=60))
def test_any_text_has_a_value_or_is_refused(text: str) -> None:
    with suppress(ExpressionError):
        assert math.isfinite(value(text)[0])


# Units


@pytest.mark.parametrize("dimension", list(UNITS))
def test_quantity_of_each_unit_has_factor_of_table(dimension: Dimension) -> None:
    for word in UNITS[dimension]:
        if word == "Hz" and dimension == "rotation":  # a frequency in formulas
            continue
        result, _ = value(f"max({f'2 {word}'.strip()}, {f'1 {word}'.strip()})")
        assert result == parse(f"2 {word}".strip(), dimension)
        assert read(node(f"2 {word}".strip())).kind(kind) == kind_of(dimension)


@pytest.mark.parametrize(
    ("dimension", "made_of"),
    [
        ("stiffness", "1 N / 1 m"),
        ("stiffness per length", "1 N / 1 m / 1 m"),
        ("damping", "1 N * 1 s / 1 m"),
        ("velocity", "1 m / 1 s"),
        ("inverse velocity", "1 s / 1 m"),
        ("density", "1 kg / (1 m) ** 3"),
        ("pressure", "1 N / (1 m) ** 2"),
        ("viscosity", "1 Pa * 1 s"),
        ("pressure coefficient", "1 / 1 Pa"),
        ("unbalance", "1 kg * 1 m"),
        ("torsional stiffness", "1 N * 1 m / 1 rad"),
        ("torsional damping", "1 N * 1 m * 1 s / 1 rad"),
        ("rotation", "1 rad / 1 s"),
        ("force", "1 kg * 1 m / (1 s) ** 2"),
        ("frequency", "1 / 1 s"),
    ],
)
def test_composed_units(dimension: Dimension, made_of: str) -> None:
    assert read(node(made_of)).kind(kind) == kind_of(dimension) != BOOLEAN


def test_every_path_can_be_named() -> None:
    """No path is a word of formulas, or a unit after a number."""
    for path in known_paths():
        result = read(node(f"2 * {path} + 1"))
        assert [name for name, _ in result.names()] == [path]


# Places


@pytest.mark.parametrize("quote", ["'", '"'])
def test_the_caret_counts_the_quote(quote: str) -> None:
    text = "min(load, 3)"
    place = Mark("f", 1, 4, f"a: {quote}{text}{quote}")
    with pytest.raises(ExpressionError) as caught:
        read(Node(text, place)).kind(kind)
    assert caught.value.mark.source_line[caught.value.mark.column - 1] == "3"


def test_a_formula_of_several_lines_is_pointed_at_its_beginning() -> None:
    place = Mark("f", 1, 4, "a: >")
    with pytest.raises(ExpressionError) as caught:
        read(Node("load\n/ 0", place)).value(VALUES.__getitem__)
    assert caught.value.mark == place
