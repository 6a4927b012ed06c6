"""Long operations are announced once on stderr, with the current step."""

import time

import pytest

from bearingsim.text.announcer import announcer


def test_long_operation_is_announced_once(capsys: pytest.CaptureFixture[str]) -> None:
    with announcer(seconds=0.05) as announcements:
        for what in ("first", "second", "third", "second"):
            announcements.begin(what)
            if what != "first":
                announcements.timer.join()
    assert capsys.readouterr().err.split() == ["second", "third"]


@pytest.mark.parametrize("enabled", [None, False])
def test_short_or_disabled_operation_is_not_announced(
    enabled: bool | None, capsys: pytest.CaptureFixture[str]
) -> None:
    with announcer(enabled, seconds=10.0 if enabled is None else 0.0) as announcements:
        announcements.begin("short")
    time.sleep(0.01)
    assert capsys.readouterr().err == ""
