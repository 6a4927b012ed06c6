"""`bearingsim freq`: any bearing whose rolling elements are known, a contact angle, and both rings turning."""

import json
from math import cos, pi, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim.cli import frequencies
from tests.scenes.commands import type_

BEARING_FILE = "name: four numbers\nelement: ball\nrollers: 15\nroller_diameter: 6 mm\npitch_diameter: 34 mm\n"


@pytest.fixture
def bearing(tmp_path):
    path = tmp_path / "b.yaml"
    path.write_text(BEARING_FILE)
    return str(path)


def first_frequencies(*words):
    result = json.loads(type_("freq", *words, "--json")[0])
    return result | {name: entry["hz"][0] for name, entry in result["frequencies"].items()}


def test_published_example(bearing):
    """Norton and Karczub, Fundamentals of Noise and Vibration Analysis for Engineers: four numbers and an angle.

    BSF is 91.65 Hz, of which they print 91.6.
    """
    result = first_frequencies(bearing, "--speed", "2000 rpm", "--contact-angle", "12.96 deg")
    assert result["FTF"] == pytest.approx(13.80, abs=0.005)
    assert result["BPFO"] == pytest.approx(207, abs=0.5)
    assert result["BPFI"] == pytest.approx(293, abs=0.5)
    assert int(result["BSF"] * 10) / 10 == 91.6


def test_contact_angle_from_the_bearing_file(bearing, tmp_path):
    (tmp_path / "angular.yaml").write_text(BEARING_FILE + "contact_angle: 12.96 deg\nbore: whatever\n")
    angular = first_frequencies(str(tmp_path / "angular.yaml"))
    assert angular == first_frequencies(bearing, "--contact-angle", "12.96 deg")
    assert first_frequencies(str(tmp_path / "angular.yaml"), "--contact-angle", "0 deg") == first_frequencies(
        bearing
    )
    stdout, _ = type_("freq", str(tmp_path / "angular.yaml"))
    assert stdout.startswith("four numbers at 1800 rpm, contact angle 12.96 deg (shaft 30 Hz)")


def test_rings_at_equal_speed_have_zero_frequencies(bearing):
    result = first_frequencies(bearing, "--speed", "1800 rpm", "--outer-speed", "1800 rpm")
    assert (result["BPFO"], result["BPFI"], result["BSF"]) == (0.0, 0.0, 0.0)
    assert result["FTF"] == pytest.approx(30.0)


@given(inner=st.integers(-3000, 3000), outer=st.integers(-3000, 3000).filter(bool), degrees=st.floats(0.0, 90.0))
def test_both_rings_turn(inner, outer, degrees):
    """Seen from either ring: speeds over the races, of which that of the elements is the mean."""
    result = frequencies.bearing_frequencies("6205", f"{inner} rpm", f"{outer} rpm", f"{degrees:.6f} deg")
    f_i, f_o, g = inner / 60.0, outer / 60.0, 7.94 / 39.04 * cos(radians(degrees))
    cage = (f_i * (1.0 - g) + f_o * (1.0 + g)) / 2.0
    spin = 39.04 / (2.0 * 7.94) * (f_i - f_o) * (1.0 - g * g)
    expected = {"BPFO": 9 * abs(cage - f_o), "BPFI": 9 * abs(f_i - cage), "FTF": abs(cage), "BSF": abs(spin)}
    for name, value in expected.items():
        assert result["frequencies"][name]["hz"][0] == pytest.approx(value, abs=1e-5), name
    assert result["cage_hz"] == pytest.approx(cage, abs=1e-5)
    assert result["outer_hz"] == pytest.approx(outer * 2 * pi / 60 / (2 * pi))


def test_single_or_counter_rotating_ring():
    result = first_frequencies("nu205", "--speed", "0 rpm", "--outer-speed", "1800 rpm")
    assert (result["BPFO"], result["BPFI"]) == pytest.approx((157.5, 232.5))
    assert result["FTF"] == pytest.approx(30.0 - 12.115, abs=1e-3)
    stdout, _ = type_("freq", "nu205", "--outer-speed", "-3000 rpm")
    assert stdout.startswith("NU205 at 1800 rpm, its outer ring at -3000 rpm (shaft 30 Hz)")
    assert "rotation of the cage, against the shaft" in stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--contact-angle", "95 deg"],
            "expected a contact angle from 0 to 90 deg, such as `15 deg`, got `95 deg`",
        ),
        (["--contact-angle", "15"], "the unit is missing"),
        (["--outer-speed", "15"], "the unit is missing"),
        (["--speed", "0 rpm", "--outer-speed", "0 rpm"], "(both rings are stationary)"),
    ],
)
def test_wrong_options_are_refused(words, message):
    assert message in type_("freq", "nf308", *words, code=2)[1]


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        ("rollers: 9\n", ["`roller_diameter` is missing", "`pitch_diameter` is missing"]),
        (BEARING_FILE.replace("15", "50"), ["b.yaml:3:10: bearing.rollers: 50 rollers do not fit: at most 17"]),
        (BEARING_FILE + "contact_angel: 3 deg", ["unknown key `contact_angel` (did you mean `contact_angle`?)"]),
        (
            BEARING_FILE + "contact_angle: -3 deg",
            ["b.yaml:6:16: bearing.contact_angle", "from 0 deg to 90 deg, got `-3 deg`"],
        ),
        (BEARING_FILE.replace("6 mm", "6"), ["b.yaml:4:18: bearing.roller_diameter", "the unit is missing"]),
        ("[1, 2]", ["expected a mapping of keys"]),
    ],
)
def test_errors_of_a_bearing_file_have_positions(tmp_path, text, messages):
    (tmp_path / "b.yaml").write_text(text)
    _, stderr = type_("freq", str(tmp_path / "b.yaml"), code=2)
    assert all(message in stderr for message in messages), stderr
