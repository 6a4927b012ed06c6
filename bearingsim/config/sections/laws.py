"""Fields that accept one of several laws of the catalogue."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any, Union

from pydantic import Discriminator, Tag

from bearingsim import catalogue, extensions
from bearingsim.config.fields import FileFormat, Section, or_words, raise_unknown_word


@dataclass(frozen=True)
class Laws:
    """Alternative sections of a field, identified by their `law`.

    words: laws that may be given as a word, which selects their defaults; default: law of an ambiguous mapping.
    """

    sections: dict[str, type[Section]]
    default: str
    words: tuple[str, ...]

    def tag(self, raw: Any) -> Any:
        """Return the law of a value."""
        if not isinstance(raw, dict):
            return getattr(raw, "law", None)
        return raw["law"] if "law" in raw else self.told_by(raw)

    def told_by(self, keys: Iterable[str]) -> str:
        """Return the only law that has all these keys, else the default."""
        fitting = [law for law, section in self.sections.items() if section.model_fields.keys() >= set(keys)]
        return fitting[0] if len(fitting) == 1 else self.default

    def spelled(self, raw: Any) -> Any:
        """Convert a word to a mapping. Unknown laws are rejected."""
        mapping = {"law": raw} if isinstance(raw, str) else raw
        law = self.tag(mapping)
        if not isinstance(law, str) or law not in self.sections:
            raise_unknown_word(self.tag(mapping), tuple(self.sections))
        return mapping

    def field(self) -> Any:
        """Return the type of a field that accepts one of the laws."""
        return Annotated[
            self.union(), Discriminator(self.tag), FileFormat(self.spelled, lambda own: or_words(own, *self.words))
        ]

    def union(self) -> Any:
        """Return the union of the sections, tagged by their laws."""
        tagged = (Annotated[section, Tag(law)] for law, section in self.sections.items())
        return Union[tuple(tagged)]  # noqa: UP007 (made at run time)


def laws_of(what: str, default: str) -> Laws:
    """Load the laws of ``what`` (`stiffness`, `damping`, `friction`) from the catalogue.

    default: law of an ambiguous mapping.
    """
    entries = catalogue.LAWS[what].values()
    sections = {law.name: section for law in entries if law.section and (section := _section(law.section))}
    return Laws(sections, default, tuple(law.name for law in entries if law.bare))


def _section(reference: str) -> type[Section] | None:
    """Import the section of a law. An extension whose section is invalid is disabled, and None returned."""
    try:
        section: type[Section] = catalogue.code(reference, type)
    except extensions.BrokenExtension as error:
        why = str(error)
    else:
        if issubclass(section, Section):
            return section
        owner = extensions.owner(reference)
        why = f"`{reference}` of the extension `{owner}` is no Section of bearingsim.config.fields"
    extensions.leave_out(extensions.owner(reference), why)
    return None
