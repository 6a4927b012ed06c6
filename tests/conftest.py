"""Settings of all tests."""

from hypothesis import settings

settings.register_profile("bearingsim", deadline=None)  # the first example may compile
settings.load_profile("bearingsim")
