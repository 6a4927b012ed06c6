"""`bearingsim freq`: the frequencies at which the parts of a bearing pass."""

from typing import Any

import typer

from bearingsim.cli.screen import print_table

__all__ = ["of_bearing", "show"]

NAMES = {
    "BPFO": "{}s over a point of the outer race",
    "BPFI": "{}s over a point of the inner race",
    "FTF": "turns of the cage",
    "BSF": "turns of a {} about its axis; a spot on it hits at 2 BSF",
}


def of_bearing(name: str, speed: str) -> dict[str, Any]:
    """Orders of shaft speed and harmonics (Hz) of the bearing's frequencies. Raises StudyError, UnitError."""
    from math import pi

    from bearingsim.config.names import HARMONICS
    from bearingsim.core.geometry import kinematics
    from bearingsim.study import load_bearing
    from bearingsim.text.units import UnitError, parse

    bearing, omega = load_bearing(name), parse(speed, "rotation")
    if omega <= 0.0:
        raise UnitError(speed, "a rotation speed above zero, such as `1800 rpm`")
    Z, D_w, d_m = bearing.rollers, bearing.roller_diameter, bearing.pitch_diameter
    hertz = {
        "BPFO": kinematics.ball_pass_frequency_outer(omega, D_w, d_m, Z),
        "BPFI": kinematics.ball_pass_frequency_inner(omega, D_w, d_m, Z),
        "FTF": kinematics.fundamental_train_frequency(omega, D_w, d_m),
        "BSF": kinematics.ball_spin_frequency(omega, D_w, d_m),
    }
    shaft = omega / (2.0 * pi)
    return {
        "bearing": bearing.name,
        "element": bearing.element,
        "shaft_hz": shaft,
        "frequencies": {
            key: {"order": value / shaft, "hz": [k * value for k in HARMONICS]} for key, value in hertz.items()
        },
    }


def show(name: str, speed: str, found: dict[str, Any]) -> None:
    """Print the frequencies as a table."""
    from bearingsim.config.names import HARMONICS

    typer.echo(f"{found['bearing'] or name} at {speed} (shaft {found['shaft_hz']:.4g} Hz)")
    heads = ["", "what", "order", *(f"{k} x (Hz)" for k in HARMONICS)]
    rows = [
        [
            key,
            NAMES[key].format(found["element"]),
            f"{entry['order']:.4f}",
            *(f"{value:.3f}" for value in entry["hz"]),
        ]
        for key, entry in found["frequencies"].items()
    ]
    print_table(heads, rows, words=2)
