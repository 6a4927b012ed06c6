"""Numbers as text."""

import pytest

from bearingsim.text.numbers import percent


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.00123, "0.12 %"), (0.126, "13 %"), (0.996, "100 %"), (11.34, "1100 %"), (float("inf"), "inf %")],
)
def test_percent_has_no_exponent(share: float, text: str) -> None:
    assert percent(share) == text
