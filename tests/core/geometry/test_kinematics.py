"""Characteristic frequencies against catalogues and other codes."""

from math import pi

import pytest

from bearingsim.core.geometry.kinematics import (
    ball_pass_frequency_inner,
    ball_pass_frequency_outer,
    ball_spin_frequency,
    fundamental_train_frequency,
)

TURN = 2.0 * pi

# Z, element and pitch diameter (any unit), shaft Hz, expected FTF, BSF, BPFO, BPFI (None: not given), tolerance
BEARINGS = {
    # 159 and 318 Hz: Yang et al., Fig. 8; the rest follows from 13 rollers of 12 mm on 65 mm
    "NF308 of the paper": (13, 12, 65, 30.0, 12.2308, 78.4808, 159.000, 231.000, 1e-3),
    # raceways 53.5 and 77.5 mm: ZKL and NTN catalogues
    "NF308 of two catalogues": (13, 12, 65.5, 30.0, None, None, 159.275, None, 1e-3),
    # orders printed by Schaeffler for NU206-E-XL, raceways 37.5 and 55.5 mm
    "NU206-E-XL": (13, 9, 46.5, 1.0, 0.40, 2.49, 5.24, 7.76, 5e-3),
    # orders of the drive-end bearing, Case Western Reserve University Bearing Data Center (BSF printed doubled)
    "6205-2RS": (9, 7.94, 39.04, 1.0, 0.39828, 2.357, 3.5848, 5.4152, 1e-3),
    # Hz at 1000 rpm, from the open-source code pybearing
    "NMB 1560kk": (7, 2.770, 10.514, 1000 / 60, 6.1379, 29.4351, 42.965, 73.7019, 3e-4),
}


@pytest.mark.parametrize("name", BEARINGS)
def test_frequencies_equal_published_values(name):
    Z, D_w, d_m, shaft, *expected, tolerance = BEARINGS[name]
    omega = TURN * shaft
    frequencies = (
        fundamental_train_frequency(omega, D_w, d_m),
        ball_spin_frequency(omega, D_w, d_m),
        ball_pass_frequency_outer(omega, D_w, d_m, Z),
        ball_pass_frequency_inner(omega, D_w, d_m, Z),
    )
    for value, printed in zip(frequencies, expected, strict=True):
        assert printed is None or value == pytest.approx(printed, abs=tolerance)


def test_inner_and_outer_passes_sum_to_shaft_turns():
    omega = TURN * 30
    total = ball_pass_frequency_outer(omega, 12, 65, 13) + ball_pass_frequency_inner(omega, 12, 65, 13)
    assert total == pytest.approx(13 * 30)
