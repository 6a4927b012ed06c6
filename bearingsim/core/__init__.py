"""Mechanics of the bearing: floats and arrays in SI units, independent of study files and results.

Increase ``MODEL_VERSION`` whenever a change alters the results of a case. It is part of every job's id, so results
of an older model are never reused as new ones. Do not rely on the golden-value test, which checks eleven scenes
only.
"""

MODEL_VERSION = 23
FORM_VERSION = 2
"""Version of the form of surfaces, increased if only results of cases with `surfaces` change. Only the ids of
their jobs contain it, so the results of other jobs remain valid."""
