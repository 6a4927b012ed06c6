"""Reference page of the keys of a study."""

from collections.abc import Collection, Iterator
from functools import cache
from typing import Any, NamedTuple

from bearingsim.catalogue import MODELS
from bearingsim.config import Case, Section
from bearingsim.config.fields import Quantity
from bearingsim.config.rules.hierarchy import needs
from bearingsim.study import descriptions, json_schema
from bearingsim.study.descriptions import field_descriptions
from bearingsim.study.paths import Field
from bearingsim.text.units import EXPECTED, Dimension, show, split
from docs.scripts.markdown import code, page, table

Keys = dict[str, Any]
BASE: Keys = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "record": [], "model": "reference"}
DEFECT: Keys = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
SHAFT: Keys = {"stiffness": "1e8 N/m", "mass": "1 kg"}
TORSION: Keys = {"torsion_stiffness": "1e4 N m/rad", "torsion_damping": "1 N m s/rad"}
TILTING: Keys = {"axial_stiffness": "1e7 N/m", "axial_damping": "1 N s/m", "tilting_stiffness": "1e4 N m/rad"}
EXAMPLES: dict[str, Keys] = {
    "load_across": {"load_across": "10 N"},
    "gravity": {"gravity": True},
    "ramp": {"ramp": {"to": "3000 rpm", "time": "1 s"}},
    "friction": {"friction": "static-dynamic"},
    "cage": {"cage": {}},
    "drag": {"drag": {}},
    "shaft": {"shaft": SHAFT},
    "unbalance": {"shaft": SHAFT, "unbalance": {"mass_radius": "100 g mm"}},
    "surfaces": {"surfaces": {"rollers": {"diameter": {"scatter": "0.5 um"}}}},
    "misalignment": {"misalignment": {"inner": "0.2 mrad"}},
    "contact.damping": {"contact": {"damping": "kraemer"}},
    "bearing.roller_profile": {"bearing": {"roller_profile": "logarithmic"}},
    "defect": {"defects": [DEFECT]},
    "defect.offset": {"defects": [DEFECT | {"offset": "1 mm"}]},
    **{f"rig.{key}": {"rig": TORSION} for key in TORSION},
    **{f"rig.{key}": {"rig": TILTING} for key in (*TILTING, "tilting_damping")},
    **{f"shaft.{key}": {"shaft": SHAFT | TILTING} for key in (*TILTING, "tilting_damping")},
    "rig.ring": {"rig": {"ring": {"bends": True}}},
    "rig.load": {"rig": {"ring": {"bends": True}, "load": {"by": "pads", "angles": ["-45 deg", "45 deg"]}}},
}
"""Keys that not every model has, with a use of each; the keys below one have the same models."""


class Part(NamedTuple):
    """Section of a study at a path: its fields make one table. law: its law, if there are several."""

    path: str
    section: type[Section]
    law: str = ""

    @property
    def title(self) -> str:
        """Heading of the section."""
        if not self.path:
            return "Keys of a case"
        return f"`{self.path}`" + (f", law `{self.law}`" if self.law else "")

    @property
    def link(self) -> str:
        """Link to the heading."""
        anchor = self.title.lower().translate(str.maketrans(" ", "-", "`.,"))
        return f"[{self.law or self.path}](#{anchor})"


def keys_page() -> str:
    """Return the page of the keys of a study."""
    tables = [_section_table(part) for part in _parts(Part("", Case))]
    return page(
        "Study keys",
        "Quantities are written with a unit, such as `0.8 mm`. A key that is not *required* may be omitted;"
        " `sweep` may set any key. *Models* are those that compute the effect of a key, where not all do."
        " `bearingsim new` writes a commented study to start from; `bearingsim check --schema` prints the schema"
        " for editors.",
        "## Keys of the study",
        table(("key", "meaning"), ((code(key), text) for key, text in descriptions.STUDY_KEYS.items())),
        *(_text_table(title, texts) for title, texts in _MAPPINGS.items()),
        *tables,
    )


_MAPPINGS = {
    "accuracy": descriptions.ACCURACY_KEYS,
    "sweep": descriptions.SWEEP_KEYS,
    "sweep: designs": descriptions.DESIGN_KEYS,
    "uncertainty": descriptions.UNCERTAINTY_KEYS,
}


def _text_table(title: str, texts: dict[str, str]) -> str:
    rows = ((code(key), text) for key, text in texts.items())
    return f"### Keys of {title}\n\n{table(('key', 'meaning'), rows)}"


def _parts(part: Part) -> Iterator[Part]:
    """Yield a section and those below it."""
    yield part
    for name in part.section.model_fields:
        yield from (inner for below in _below(part, name) for inner in _parts(below))


def _below(part: Part, name: str) -> list[Part]:
    """List the sections that a field may have."""
    sections = [mark for mark in Field(part.section, name).marks if isinstance(mark, type)]
    sections = [mark for mark in dict.fromkeys(sections) if issubclass(mark, Section)]
    path = f"{part.path}.{'defect' if name == 'defects' else name}".lstrip(".")
    return [Part(path, section, _law(section)) for section in sections]


def _law(section: type[Section]) -> str:
    law = section.model_fields.get("law")
    return str(law.default) if law else ""


def _section_table(part: Part) -> str:
    """Return the heading of a section and the table of its keys."""
    properties, texts = _schemas()[part.section], field_descriptions(part.section)
    names = [name for name in part.section.model_fields if name != "law" and name in properties]
    models = [_models(part, name) for name in names]
    rows = [
        [code(name), text, _value(part, name), _default(part.section, name, text), model]
        for name, model in zip(names, models, strict=True)
        for text in [texts.get(name, "")]
    ]
    head = ["key", "meaning", "value", "default", "models"]
    parts = [
        f"## {part.title}",
        " ".join((part.section.__doc__ or "").partition("\n\n")[0].split()) if part.path else "",
    ]
    if len(set(models)) == 1:
        rows, head = [row[:-1] for row in rows], head[:-1]
        parts.append(f"Models: {models[0]}." if models[0] else "")
    parts.append(table(head, rows) if rows else "The law has no keys.")
    return "\n\n".join(filter(None, parts))


@cache
def _schemas() -> dict[type[Section], dict[str, Any]]:
    """Return the schemas of the keys of each section."""
    schema = json_schema()
    sections = {part.section for part in _parts(Part("", Case))}
    return {s: (schema if s is Case else schema["$defs"][s.__name__])["properties"] for s in sections}


def _value(part: Part, name: str) -> str:
    """Describe the values of a key: words, a quantity with its bounds, sections."""
    field, schema = Field(part.section, name), _schemas()[part.section][name]
    texts = [text for inner in schema.get("anyOf", [schema]) if (text := _format(inner))]
    quantity = next((mark for mark in field.marks if isinstance(mark, Quantity)), None)
    if quantity and quantity != type(quantity)(quantity.dimension):  # it has bounds
        texts.append(quantity.bound_text().removeprefix("that is "))
    sections = ", ".join(inner.link for inner in _below(part, name))
    if sections:
        texts.append(f"{'list of mappings' if schema.get('type') == 'array' else 'mapping'}: {sections}")
    return "; ".join(dict.fromkeys(texts))


def _format(schema: dict[str, Any]) -> str:
    """Describe the values of a schema; empty for a section."""
    match schema:
        case {"enum": words}:
            return code(*map(str, dict.fromkeys(words))) if len(words) < MAX_WORDS else ""
        case {"const": word}:
            return code(str(word))
        case {"examples": words}:
            return f"{code(*map(str, words))}; a file"
        case {"patternErrorMessage": message}:
            return str(message).removeprefix("expected ")
        case {"type": "integer", "minimum": low, "maximum": high}:
            return f"a whole number from {low} to {high}"
        case {"type": "boolean"}:
            return code("true", "false")
        case {"type": "array", "items": items}:
            words = "; ".join(filter(None, map(_format, items.get("anyOf", [items]))))
            return f"a list of {words}" if words else ""
        case {"type": list()}:
            return "text"
    return ""


MAX_WORDS = 40


def _default(section: type[Section], name: str, description: str) -> str:
    """Return the default of a key as a study writes it; empty if it has none, or if its description names it."""
    field, kind = section.model_fields[name], Field(section, name)
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    if value in (None, "", ()) or "Default:" in description:
        return ""
    match value:
        case Section():
            label = getattr(value, "law", "") or getattr(value, "shape", "")
            return code(label) if label else "its defaults"
        case bool():
            return code(str(value).lower())
        case tuple():
            return code(f"[{', '.join(map(str, value))}]")
        case float() if kind.dimension:
            return code(_quantity(value, kind.dimension))
    return code(str(value))


def _quantity(value: float, dimension: Dimension) -> str:
    """Format a quantity in the unit of the dimension's example; times in the largest unit that is not above it."""
    units = ("s", "ms", "us") if dimension == "time" else (split(EXPECTED[dimension].split("`")[1])[1],)
    texts = [show(value, unit, dimension) for unit in units]
    return next((text for text in texts if not text.startswith("0.")), texts[0]).replace("e+0", "e")


def _models(part: Part, name: str) -> str:
    """List the models of a key, if not all have it: those of its example, or of the section above it."""
    path = f"{part.path}.{name}".lstrip(".")
    steps = path.split(".")
    prefixes = [".".join(steps[:i]) for i in range(len(steps), 0, -1)]
    example = next((prefix for prefix in prefixes if prefix in EXAMPLES), None)
    return models_of_example(example) if example else ""


@cache
def models_of_example(path: str) -> str:
    """List the models that compute the effect of a key of ``EXAMPLES``; empty if all do."""
    keys = EXAMPLES[path]
    if "bearing" in keys:
        keys = {"bearing": Case(**BASE).bearing.model_dump(exclude_none=True) | keys["bearing"]}
    without = {need.ability for need in needs(Case(**BASE))}
    return models_with({need.ability for need in needs(Case(**BASE | keys))} - without)


def models_of_channel(name: str) -> str:
    """List the models that record a channel; empty if all do."""
    bearing = Case(**BASE).bearing.model_dump(exclude_none=True) | {"flanges": {"inner": 2}}
    moving = {"rig": TORSION | TILTING, "shaft": SHAFT | TILTING, "cage": {"guide": "outer-ring"}}
    recorded = needs(Case(**BASE | moving | {"bearing": bearing, "record": [name]}))
    return models_with({need.ability for need in recorded if need.paths[0][0] == "record"})


def models_with(abilities: Collection[str]) -> str:
    """List the models with these abilities; empty if all have them."""
    names = [name for name, model in MODELS.items() if model.abilities.issuperset(abilities)]
    return code(*names) if len(names) < len(MODELS) else ""
