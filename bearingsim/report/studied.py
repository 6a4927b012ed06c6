"""Subject of a study in words: bearing, defect, varied and fixed parameters."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from bearingsim.config.names import Line
from bearingsim.plots import labels, lines, select
from bearingsim.plots.caption import CAPTION_FIELDS, SMALL_UNITS, defect_values, machine_values
from bearingsim.study import plotted_features
from bearingsim.study.uncertainty import PARAMETER_KINDS, group_by_kind
from bearingsim.text.numbers import significant, span

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

MAX_VALUES = 6
"""Largest number of values of a swept parameter that are listed; for more, their range and number."""
DIMENSIONS = {
    "bearing.roller_diameter": "D_w",
    "bearing.roller_length": "L",
    "bearing.pitch_diameter": "pitch diameter",
    "bearing.bore": "bore",
    "bearing.outside_diameter": "outside diameter",
    "bearing.width": "width",
    "clearance": "radial clearance",
}
"""Parameters of a bearing on the page, with their names."""
DAMPING = {path for path, _ in CAPTION_FIELDS if path.startswith("contact.damping.")}
"""Parameters of the contact damping."""
FREQUENCIES = {family.line: family.fundamental for family in lines.FAMILIES.values()} | {
    "FTF": Line(cage=1),
    "fr": lines.SHAFT,
}
"""Characteristic frequencies of a bearing, by name."""

Fact = tuple[str, str]
"""Name of a fact, and its value."""


def study_facts(results: "Results") -> Iterator[Fact]:
    """Yield facts on the bearing, swept and uncertain parameters, design, defect, fixed parameters, directions."""
    rows, units = select.case_rows(results), results.plan["units"]
    parameters = results.parameters()
    parameters = parameters.loc[parameters.index.intersection(list(rows["job"]))]
    tried = group_by_kind((variation["what"], variation["value"]) for variation in results.variations)
    if len(parameters):
        yield "Bearing", ", ".join(_bearing(parameters, units, "clearance" in tried))
        yield "Frequencies", ", ".join(_frequencies(parameters))
    varied = select.varied_paths(rows, list(units))
    texts = [f"{labels.name_text(path)} {_values_text(path, rows, units)}" for path in varied]
    if texts:
        yield "Varied", "; ".join(texts)
    if tried:
        ranges = [
            labels.format_quantity(PARAMETER_KINDS[name].range_text(values)) for name, values in tried.items()
        ]
        laws = machine_values(results, rows, {"rig", *(path for path, _ in CAPTION_FIELDS)} - DAMPING)
        nominal = {"damping": ", ".join(laws).removeprefix("damping ")}
        nominal["clearance"] = _span("clearance", parameters, SMALL_UNITS | dict(units))
        nominal_texts = [f", nominal: {nominal[name]}" if nominal.get(name) else "" for name in tried]
        counts = [f" ({len(set(values))} values" for values in tried.values()]
        details = [  # the range of samples states their number
            "" if PARAMETER_KINDS[name].samples else f"{count}{text})"
            for name, count, text in zip(tried, counts, nominal_texts, strict=True)
        ]
        texts = [f"{name} {text}{detail}" for name, text, detail in zip(tried, ranges, details, strict=True)]
        yield "Varied (uncertainty)", "; ".join(texts) + "; one at a time" * (len(tried) > 1)
    if results.plan["design"]:
        from bearingsim.plots.design import describe_design

        yield "Design", describe_design(results.plan["design"])
    stated = set(varied) | {"bearing.name", "clearance"}
    if "damping" in tried:
        stated |= DAMPING
    defect = [*_races(parameters), *defect_values(results, rows, stated)]
    if defect:
        yield "Defect", f"{', '.join(defect)}; length along the roller, width along the race"
    fixed = [*machine_values(results, rows, stated), *["quick grid"] * bool(results.plan["quick"])]
    if fixed:
        yield "Fixed", ", ".join(fixed)
    if len(parameters) and "rig.sensor.angle" in parameters and "rig.sensor.angle" not in varied:
        angle = _span("rig.sensor.angle", parameters, units)
        origin = "angles from the load line, the centre of the load zone"
        yield "Directions", f"{origin}; sensor at {angle}, positive outward"


def describe_subject(results: "Results") -> str:
    """Describe bearing, defect and the features of the figures: `NU210, outer race: RMS velocity over load`."""
    rows, units = select.case_rows(results), results.plan["units"]
    parameters = results.parameters()
    parameters = parameters.loc[parameters.index.intersection(list(rows["job"]))]
    if parameters.empty:
        return ""
    bearing = " / ".join(dict.fromkeys(map(str, parameters["bearing.name"])))
    defect = [f"defect of the {race}" for race in _races(parameters)] or ["no defect"]
    names = list(dict.fromkeys(map(labels.feature_text, plotted_features(results.plan))))
    varied = [labels.name_text(path) for path in select.varied_paths(rows, list(units))]
    texts = [labels.in_sentence(name) for name in names[:2]] or ["vibration"]
    quantities = " and ".join(texts) + ", and others" * (len(names) > 2)
    over = [f"over {' and '.join(varied)}"] if varied else []
    return f"{', '.join([bearing, *defect])}: {' '.join([quantities, *over])}"


def _bearing(parameters: "pd.DataFrame", units: dict[str, str], uncertain_clearance: bool) -> Iterator[str]:
    """Yield name, number of rolling elements and dimensions of the bearing, or their ranges over the cases."""
    yield " / ".join(dict.fromkeys(map(str, parameters["bearing.name"])))
    elements = " / ".join(f"{element}s" for element in dict.fromkeys(parameters["bearing.element"]))
    yield f"Z = {_span('bearing.rollers', parameters, units)} {elements}"
    for path, name in DIMENSIONS.items():
        shown = path in parameters and parameters[path].notna().any()
        if shown and not (uncertain_clearance and path == "clearance"):
            yield f"{name} {_span(path, parameters, SMALL_UNITS | dict(units))}"


def _span(path: str, parameters: "pd.DataFrame", units: dict[str, str]) -> str:
    values = parameters[path]
    return span(float(values.min()), float(values.max()), lambda end: labels.value_text(path, end, units))


def _frequencies(parameters: "pd.DataFrame") -> Iterator[str]:
    """Yield the characteristic frequencies, `BPFO 159 Hz`, or their ranges over the speeds, ramps included."""
    for name, line in FREQUENCIES.items():
        values = lines.frequencies(line, parameters)
        yield f"{name} {span(min(values), max(values), significant)} Hz"


def _races(parameters: "pd.DataFrame") -> list[str]:
    """Name the elements that carry the defects, `outer race`."""
    texts = [race if race == "roller" else f"{race} race" for race in lines.races_of_all(parameters)]
    return [" and ".join(texts)] if texts else []


def _values_text(path: str, rows: "pd.DataFrame", units: dict[str, str]) -> str:
    distinct = select.distinct_values(rows, path)
    if len(distinct) > MAX_VALUES and select.is_numeric(distinct):
        ends = [labels.value_text(path, value, units) for value in (distinct[0], distinct[-1])]
        return f"{ends[0]} to {ends[1]}, {len(distinct)} values"
    texts = [labels.value_text(path, value, units) for value in distinct[: 3 * MAX_VALUES]]
    return ", ".join(texts + ["and more"] * (len(distinct) > len(texts)))
