"""The mechanics of the bearing: floats and arrays in SI, nothing else of the program.

``MODEL_VERSION`` is raised by hand whenever a change makes the same case give different numbers; it is part
of every job's id, so results computed by an older model are never taken for new ones. A golden-value test
guards it.
"""

MODEL_VERSION = 11
