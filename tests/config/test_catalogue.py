"""Shipped bearings and clearance classes, compared with catalogues of manufacturers."""

from itertools import pairwise
from math import pi
from pathlib import Path

import pytest
from pydantic import ValidationError

from bearingsim.cli import frequencies
from bearingsim.config import Bearing, Case, library_names
from bearingsim.config.library import load_mapping
from bearingsim.config.sections.clearance import CLASSES, limits, mean_clearance

CATALOGUE = ("nf308", "nf308-catalogue", "nu206", "nu205", "nu204", "nu209", "6205", "6203")


def load_bearing(name: str) -> Bearing:
    return Bearing.model_validate(load_mapping("bearings", name))


def test_the_catalogue_is_complete() -> None:
    assert set(CATALOGUE) <= set(library_names("bearings"))


@pytest.mark.parametrize("name", CATALOGUE)
def test_bearing_is_read_with_the_source_of_its_data(name: str) -> None:
    bearing = load_bearing(name)
    assert len(bearing.source) > 40
    text = (Path(__file__).parents[2] / "configs" / "bearings" / f"{name}.yaml").read_text()
    assumed = {"roller": "roller_length", "ball": "inner_groove_radius"}[bearing.element]
    line = next(line for line in text.splitlines() if line.startswith(assumed))
    assert "assumption" in line or (name == "nu209" and "effective" in line)


@pytest.mark.parametrize(
    ("name", "orders", "tolerance"),
    [
        # the paper's outer-race frequency, 159 Hz at 1800 rpm; the others follow
        ("nf308", {"BPFO": 159 / 30, "BPFI": 231 / 30, "FTF": 12.2308 / 30, "BSF": 78.4808 / 30}, 4e-5),
        # ZKL and NTN: raceways 53.5 and 77.5 mm
        ("nf308-catalogue", {"BPFO": 159.275 / 30}, 4e-5),
        # Schaeffler, NU206-E-XL, two decimals
        ("nu206", {"BPFO": 5.24, "BPFI": 7.76, "BSF": 2.49, "FTF": 0.40}, 0.005),
        # Case Western Reserve University, bearing information; what it prints for the rolling element is 2 BSF
        ("6205", {"BPFO": 3.5848, "BPFI": 5.4152, "FTF": 0.39828, "BSF": 4.7135 / 2}, 1e-3),
        ("6203", {"BPFO": 3.0530, "BPFI": 4.9469, "FTF": 0.3817, "BSF": 3.9874 / 2}, 1e-3),
    ],
)
def test_characteristic_frequencies_equal_the_catalogue(
    name: str, orders: dict[str, float], tolerance: float
) -> None:
    result = frequencies.bearing_frequencies(name, "1800 rpm")["frequencies"]
    assert {key: result[key]["order"] for key in orders} == pytest.approx(orders, abs=tolerance)


@pytest.mark.parametrize(
    ("name", "inner", "outer"),
    [
        ("nf308-catalogue", 53.5, 77.5),  # ZKL, NTN
        ("nu206", 37.5, 55.5),  # Schaeffler
        ("nu205", 31.5, 46.5),  # SKF
        ("nu204", 26.5, 41.5),  # SKF
        ("nu209", 55.0, 75.0),  # Harris: 54.991 and 75.032 mm with 0.041 mm of clearance
    ],
)
def test_raceway_diameters_equal_the_catalogue(name: str, inner: float, outer: float) -> None:
    bearing = load_bearing(name)
    assert 1e3 * (bearing.pitch_diameter - bearing.roller_diameter) == pytest.approx(inner)
    assert 1e3 * (bearing.pitch_diameter + bearing.roller_diameter) == pytest.approx(outer)


@pytest.mark.parametrize(
    ("name", "printed"),
    [("nu204", 22e3), ("nu205", 27e3), ("nu206", 36.5e3)],  # SKF catalogue, NU 204, 205, 206 ECP
)
def test_static_load_rating_equals_the_catalogue(name: str, printed: float) -> None:
    """ISO 76, radial roller bearings: C0 = 44 (1 - D_w/d_m) Z L D_w in N and mm."""
    b = load_bearing(name)
    assert b.roller_length is not None
    gamma = b.roller_diameter / b.pitch_diameter
    load = 44.0 * (1.0 - gamma) * b.rollers * 1e6 * b.roller_length * b.roller_diameter
    assert load == pytest.approx(printed, rel=0.01)


def test_rolling_elements_of_ball_bearings_are_balls(capsys: pytest.CaptureFixture[str]) -> None:
    for name, word in (("6205", "balls over"), ("nu205", "rollers over")):
        frequencies.show(name, "1800 rpm", frequencies.bearing_frequencies(name, "1800 rpm"))
        assert word in capsys.readouterr().out


# Clearance


@pytest.mark.parametrize(
    ("element", "bore", "micrometres"),
    [
        # ISO 5753-1, cylindrical roller bearings with a cylindrical bore
        ("roller", 20, {"C2": (0, 25), "CN": (20, 45), "C3": (35, 60), "C4": (50, 75), "C5": (65, 90)}),
        ("roller", 25, {"C2": (0, 25), "CN": (20, 45), "C3": (35, 60), "C4": (50, 75), "C5": (70, 95)}),
        ("roller", 40, {"C2": (5, 30), "CN": (25, 50), "C3": (45, 70), "C4": (60, 85), "C5": (80, 105)}),
        ("roller", 45, {"C2": (5, 35), "CN": (30, 60), "C3": (50, 80), "C4": (70, 100), "C5": (95, 125)}),
        # ISO 5753-1, deep groove ball bearings
        ("ball", 17, {"C2": (0, 9), "CN": (3, 18), "C3": (11, 25), "C4": (18, 33), "C5": (25, 45)}),
        ("ball", 25, {"C2": (1, 11), "CN": (5, 20), "C3": (13, 28), "C4": (23, 41), "C5": (30, 53)}),
    ],
)
def test_classes_of_clearance(element: str, bore: float, micrometres: dict[str, tuple[float, float]]) -> None:
    result = {word: limits(word, element, 1e-3 * bore) for word in CLASSES}
    expected = {word: (1e-6 * low, 1e-6 * high) for word, (low, high) in micrometres.items()}
    assert result == {word: pytest.approx(pair) for word, pair in expected.items()}


def test_bore_at_a_limit_belongs_to_the_lower_row() -> None:
    assert limits("CN", "roller", 0.030) == pytest.approx((20e-6, 45e-6))
    assert limits("CN", "roller", 0.0301) == pytest.approx((25e-6, 50e-6))


@pytest.mark.parametrize("element", ["roller", "ball"])
def test_clearance_increases_with_the_class(element: str) -> None:
    for bore in range(11, 121):
        rows = [limits(word, element, 1e-3 * bore) for word in CLASSES]
        assert all(a[0] < b[0] < b[1] and a[1] < b[1] for a, b in pairwise(rows))


def case(bearing: object, clearance: str) -> Case:
    return Case.model_validate({"bearing": bearing, "speed": "1800 rpm", "load": "150 N", "clearance": clearance})


def test_clearance_of_a_class_is_the_middle_of_its_range() -> None:
    assert case("nf308", "CN").clearance == 37.5e-6
    assert case("6205", "C3").clearance == 20.5e-6
    assert mean_clearance("C2", "ball", 0.017) == 4.5e-6


def test_bore_beyond_the_table_is_refused() -> None:
    large = load_bearing("nf308").model_dump() | {"bore": 0.2, "pitch_diameter": 0.25, "outside_diameter": 0.3}
    with pytest.raises(ValidationError, match="class CN is defined for bores over 0 to 120 mm, not for 200 mm"):
        case(large, "CN")
    with pytest.raises(ValueError, match="over 6 to 120 mm, not for 6 mm"):
        limits("CN", "ball", 0.006)


def test_invalid_bearing_is_reported_once() -> None:
    with pytest.raises(ValidationError) as caught:
        case("nf309", "CN")
    assert len(caught.value.errors()) == 1


def test_every_catalogue_bearing_has_every_class() -> None:
    for name in CATALOGUE:
        clearances = [case(name, word).clearance for word in CLASSES]
        assert clearances == sorted(clearances)
        bearing: Bearing = load_bearing(name)
        assert bearing.roller_spacing > pi * bearing.roller_diameter / 3
