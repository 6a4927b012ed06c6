"""Numbers as text."""

import pytest

from bearingsim.text.html import describe_values
from bearingsim.text.numbers import percent, significant


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.00123, "0.12 %"), (0.126, "13 %"), (0.996, "100 %"), (11.34, "1100 %"), (float("inf"), "inf %")],
)
def test_percent_has_no_exponent(share: float, text: str) -> None:
    assert percent(share) == text


def test_zero_has_no_sign() -> None:
    assert significant(-0.0) == "0"


def test_values_are_described_by_their_ends_in_any_order() -> None:
    assert describe_values([300.0, 100.0, 200.0], "{:g} N".format) == "3 values, 100 N to 300 N"
    assert describe_values(["ring", "planar", "static"], str) == "3 values, ring to static"
