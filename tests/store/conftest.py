"""Fixtures of the tests of stored results."""

import pytest

from tests.scenes.fake_studies import FakeStudy


@pytest.fixture
def study() -> FakeStudy:
    return FakeStudy()
