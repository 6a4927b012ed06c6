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

    sections: section of each law; default: law of an ambiguous mapping; words: laws that may be given as a word,
    which selects their default parameters.
    """

    sections: dict[str, type[Section]]
    default: str
    words: tuple[str, ...]

    def tag(self, raw: Any) -> Any:
        """Return the law of a value: that of its key `law`, or else of its other keys; None for another type."""
        if not isinstance(raw, dict):
            return getattr(raw, "law", None)
        return raw["law"] if "law" in raw else self.match_law(raw)

    def match_law(self, keys: Iterable[str]) -> str:
        """Return the only law that has all these keys, or else the default law."""
        matches = [law for law, section in self.sections.items() if section.model_fields.keys() >= set(keys)]
        return matches[0] if len(matches) == 1 else self.default

    def as_mapping(self, raw: Any) -> Any:
        """Convert a word to a mapping. Raises the error of a validator for an unknown law."""
        mapping = {"law": raw} if isinstance(raw, str) else raw
        law = self.tag(mapping)
        if not isinstance(law, str) or law not in self.sections:
            raise_unknown_word(self.tag(mapping), tuple(self.sections))
        return mapping

    def field(self) -> Any:
        """Return the type of a field that accepts one of the laws."""
        return Annotated[
            self.union(),
            Discriminator(self.tag),
            FileFormat(self.as_mapping, lambda schema: or_words(schema, *self.words)),
        ]

    def union(self) -> Any:
        """Return the union of the sections, tagged by their laws."""
        members = (Annotated[section, Tag(law)] for law, section in self.sections.items())
        return Union[tuple(members)]  # noqa: UP007 (made at run time)


def laws_of(kind: str, default: str) -> Laws:
    """Load the laws of a kind (`stiffness`, `damping` or `friction`) from the catalogue.

    default: law of an ambiguous mapping.
    """
    entries = catalogue.LAWS[kind].values()
    sections = {law.name: section for law in entries if law.section and (section := _section(law.section))}
    return Laws(sections, default, tuple(law.name for law in entries if law.bare))


def _section(reference: str) -> type[Section] | None:
    """Import the section of a law. If that of an extension is invalid, record the failure and return None."""
    try:
        section: type[Section] = catalogue.code(reference, type)
    except extensions.BrokenExtension as error:
        message = str(error)
    else:
        if issubclass(section, Section):
            return section
        owner = extensions.owner(reference)
        message = f"`{reference}` of the extension `{owner}` is not a subclass of bearingsim.config.fields.Section"
    extensions.record_failure(extensions.owner(reference), message)
    return None
