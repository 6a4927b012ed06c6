"""The mechanics of the bearing, with floats and arrays in SI units and independent of the rest of the program.

Increase ``MODEL_VERSION`` whenever a change alters the results of a case. It is part of every job's id, so results
of an older model are never reused as new ones. A golden-value test checks eleven scenes only.
"""

MODEL_VERSION = 21
FORM_VERSION = 2
"""Version of the form of surfaces, raised if only results of cases with `surfaces` change. It is part of the ids
of these jobs alone, so that others remain valid."""
