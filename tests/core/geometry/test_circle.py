"""Cosine and sine against those of the mathematical library."""

from math import cos, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim.core.geometry.plane import cos_sin
from bearingsim.core.jit import jit


@jit
def compiled_cos_sin(angle):
    return cos_sin(angle)


@given(st.floats(-1e4, 1e4))
def test_cosine_and_sine_equal_the_library(angle):
    C, S = compiled_cos_sin(angle)
    rounding = 3e-16 + 2e-16 * abs(angle)
    assert abs(C - cos(angle)) <= rounding
    assert abs(S - sin(angle)) <= rounding


@pytest.mark.parametrize("eighths", range(-17, 18))
def test_multiples_of_an_eighth_turn(eighths):
    angle = eighths * pi / 4.0
    C, S = compiled_cos_sin(angle)
    assert abs(C - cos(angle)) <= 1e-15
    assert abs(S - sin(angle)) <= 1e-15
    assert abs(C * C + S * S - 1.0) <= 4e-16
