"""`bearingsim freq`: characteristic frequencies of a bearing."""

from typing import Any

from bearingsim.cli.screen import print_table
from bearingsim.text.terminal import say

DESCRIPTIONS = {
    "BPFO": "{}s over a point of the outer race",
    "BPFI": "{}s over a point of the inner race",
    "FTF": "rotation of the cage",
    "BSF": "rotation of a {} about its axis; a defect strikes at 2 BSF",
}


def bearing_frequencies(
    name: str, speed: str, outer_speed: str | None = None, contact_angle: str | None = None
) -> dict[str, Any]:
    """Compute the characteristic frequencies of a bearing, with harmonics (Hz) and as orders.

    Ring speeds with opposite signs mean counter-rotation. With g = d cos(a)/D, the cage speed is FTF = [f_i (1 -
    g) + f_o (1 + g)]/2; BPFO = Z |FTF - f_o|, BPFI = Z |f_i - FTF|, and BSF = D/(2 d) |f_i - f_o| (1 - g^2),
    relative to the cage (Harris, Rolling Bearing Analysis, ch. 8). All but FTF depend only on the speed of the
    inner ring relative to the outer ring. Frequencies are magnitudes; `cage_hz` is signed. Orders refer to the
    speed of the inner ring, or of the outer ring if the inner ring is stationary.

    Raises StudyError, UnitError.
    """
    from math import pi

    from bearingsim.config.names import HARMONICS
    from bearingsim.core.geometry import kinematics
    from bearingsim.study import load_rolling_parts
    from bearingsim.text.units import parse

    parts, inner = load_rolling_parts(name), parse(speed, "rotation")
    outer = 0.0 if outer_speed is None else parse(outer_speed, "rotation")
    _check_speeds(speed, inner, outer_speed, outer)
    angle = parts.contact_angle if contact_angle is None else _contact_angle(contact_angle)
    D_w, d_m, Z = parts.roller_diameter, parts.pitch_diameter, parts.rollers
    cage_hz = outer / (2.0 * pi) + kinematics.fundamental_train_frequency(inner - outer, D_w, d_m, angle)
    hertz = {
        "BPFO": abs(kinematics.ball_pass_frequency_outer(inner - outer, D_w, d_m, Z, angle)),
        "BPFI": abs(kinematics.ball_pass_frequency_inner(inner - outer, D_w, d_m, Z, angle)),
        "FTF": abs(cage_hz),
        "BSF": abs(kinematics.ball_spin_frequency(inner - outer, D_w, d_m, angle)),
    }
    shaft_hz = abs(inner or outer) / (2.0 * pi)
    return {
        "bearing": parts.name,
        "element": parts.element,
        "contact_angle_deg": angle * 180.0 / pi,
        "inner_hz": inner / (2.0 * pi),
        "outer_hz": outer / (2.0 * pi),
        "cage_hz": cage_hz,
        "shaft_hz": shaft_hz,
        "frequencies": {
            key: {"order": value / shaft_hz, "hz": [k * value for k in HARMONICS]} for key, value in hertz.items()
        },
    }


def _check_speeds(speed: str, inner: float, outer_speed: str | None, outer: float) -> None:
    """Raise UnitError for an inner speed that is not positive without an outer one, and for two speeds of zero."""
    from bearingsim.text.units import UnitError

    if inner <= 0.0 and outer_speed is None:
        raise UnitError(speed, "a rotation speed above zero, such as `1800 rpm`")
    if inner == outer == 0.0:
        raise UnitError(
            speed, "a rotation speed of one of the rings, such as `1800 rpm`", "both rings are stationary"
        )


def _contact_angle(text: str) -> float:
    """Parse a contact angle, in rad. Raises UnitError outside 0 to 90 deg."""
    from math import pi

    from bearingsim.text.units import UnitError, parse

    angle = parse(text, "angle")
    if not 0.0 <= angle <= pi / 2.0:
        raise UnitError(text, "a contact angle from 0 to 90 deg, such as `15 deg`")
    return angle


def show(name: str, speed: str, values: dict[str, Any], outer_speed: str | None = None) -> None:
    """Print the frequencies as a table."""
    from bearingsim.config.names import HARMONICS

    outer = "" if outer_speed is None else f", its outer ring at {outer_speed}"
    angle = f", contact angle {values['contact_angle_deg']:.4g} deg" if values["contact_angle_deg"] else ""
    ring = "shaft" if values["inner_hz"] else "outer ring"
    say(f"{values['bearing'] or name} at {speed}{outer}{angle} ({ring} {values['shaft_hz']:.4g} Hz)")
    headers = ["", "event", "order", *(f"{k} x (Hz)" for k in HARMONICS)]
    cage_reversed = values["cage_hz"] * (values["inner_hz"] or values["outer_hz"]) < 0.0
    rows = [
        [
            key,
            DESCRIPTIONS[key].format(values["element"])
            + f", against the {ring}" * (cage_reversed and key == "FTF"),
            f"{entry['order']:.4f}",
            *(f"{hertz:.3f}" for hertz in entry["hz"]),
        ]
        for key, entry in values["frequencies"].items()
    ]
    print_table(headers, rows, text_columns=2)
