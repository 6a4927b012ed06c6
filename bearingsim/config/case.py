"""Case of a study: its fields, completed and checked for conflicts."""

from collections.abc import Iterator
from typing import Any

from pydantic import model_validator

from bearingsim.config.case_fields import DEPRECATED_KEYS, CaseFields
from bearingsim.config.fields import Quantity, Section, refuse
from bearingsim.config.rules.completion import complete
from bearingsim.config.rules.conflicts import conflicts
from bearingsim.config.sections import contact, free
from bearingsim.config.sections.laws import Laws
from bearingsim.text.html import table_html
from bearingsim.text.units import DISPLAY, show

LAWS: dict[tuple[str | int, ...], Laws] = {
    ("contact", "damping"): contact.DAMPING,
    ("contact", "stiffness"): contact.STIFFNESS,
    ("friction",): free.FRICTION,
}
"""Available laws of each field that selects a law, by the field's path."""


class Case(CaseFields):
    """One simulation, in SI, with all dependent values filled in (``rules/completion.py``).

    `defect` (one mapping) may be given instead of `defects`.
    """

    @model_validator(mode="before")
    @classmethod
    def _single_defect(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        for old, new in DEPRECATED_KEYS.items():
            if old in data and new in data:
                refuse("twice", f"`{old}` is now called `{new}`", "keep one of them", at=old)
        data = {DEPRECATED_KEYS.get(key, key): value for key, value in data.items()}
        if "defect" not in data:
            return data
        if "defects" in data:
            refuse("defects", "use `defect` (one mapping) or `defects` (a list), not both", at="defect")
        return {key: value for key, value in data.items() if key != "defect"} | {"defects": [data["defect"]]}

    @model_validator(mode="after")
    def _complete(self) -> "Case":
        complete(self)
        problems = list(conflicts(self))
        if problems:
            message = "; ".join(conflict.message for conflict in problems)
            refuse("conflict", message, conflicts=problems)
        return self

    def _repr_html_(self) -> str:
        """Return a summary for notebooks: the machine, its defects, and how it is computed."""
        rows = [("bearing", self.bearing.name), *_quantities(self, "speed", "load", "clearance")]
        for number, defect in enumerate(self.defects, 1):
            sizes = ", ".join(
                f"{name} {text}" for name, text in _quantities(defect, "length", "width", "depth", "angle")
            )
            rows.append((f"defect {number}", f"{defect.shape} on {defect.race}: {sizes}"))
        rows += [
            ("model", self.model),
            ("method", self.method or "none"),
            *_quantities(self, "duration", "sampling"),
        ]
        return table_html("Case", [*rows, ("record", ", ".join(self.record))])


def _quantities(section: Section, *names: str) -> Iterator[tuple[str, str]]:
    """Yield the names of fields and their values in display units."""
    for name in names:
        annotations = type(section).model_fields[name].metadata
        dimension = next(entry.dimension for entry in annotations if isinstance(entry, Quantity))
        yield name, show(getattr(section, name), DISPLAY[dimension], dimension)
