"""What all cases of a figure have in common, for the line below it."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING

from bearingsim.config.bands import FLAT
from bearingsim.plots import labels, select

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results
    from bearingsim.study import Figure

__all__ = ["band_of_record", "fixed_values", "moved_along", "varying"]

CAPTION_FIELDS = (  # parameters worth saying, in order, with the word that introduces the value
    ("bearing.name", ""),
    ("speed", ""),
    ("ramp.to", "ramp to"),
    ("load", "load"),
    ("load_across", "across"),
    ("clearance", "clearance"),
    ("misalignment.inner", "inner ring askew by"),
    ("misalignment.outer", "outer ring askew by"),
    ("bearing.roller_profile.shape", "roller profile"),
    ("contact.stiffness", "stiffness"),
    ("contact.stiffness.coefficient", "stiffness coefficient"),
    ("contact.stiffness.exponent", "exponent"),
    ("contact.damping.law", "damping"),
    ("contact.damping.chi", "chi"),
    ("contact.damping.beta", "beta"),
    ("contact.damping.oil", ""),
    ("contact.damping.temperature", "at"),
    ("contact.damping.viscosity", "viscosity"),
    ("contact.damping.loss_factor", "loss factor"),
    ("contact.damping.coefficient", "coefficient"),
    ("contact.damping.velocity_exponent", "m2"),
    ("contact.damping.indentation_exponent", "m3"),
    ("excitation", ""),
    ("model", "model"),
    ("friction.law", "friction"),
    ("cage.guide", "cage guide"),
    ("drag.oil_fraction", "oil fraction"),
    ("method", "method"),
    ("duration", "record"),
)
USUAL = {
    "excitation": "envelope",
    "load_across": 0.0,
    "misalignment.inner": 0.0,
    "misalignment.outer": 0.0,
    "bearing.roller_profile.shape": "straight",
}  # not worth saying
SIZES = ("grown", "seed", "file", "length", "width", "depth", "angle", "offset", "edge.radius", "edge.ramp")
DEFECT = ("shape", *SIZES)
SMALL = {
    "clearance": "um",
    "contact.damping.beta": "us",
    "misalignment.inner": "mrad",
    "misalignment.outer": "mrad",
}


MOST_WORDS = 4
STATISTICS = {"rms": "RMS", "peak": "peak", "crest": "crest factor", "kurtosis": "kurtosis"}
"""Of a record, whose band ends with its sampling."""


def fixed_values(results: "Results", rows: "pd.DataFrame", drawn: set[str]) -> list[str]:
    """Resolved parameters that do not vary over the finished jobs of ``rows``, in words.

    drawn: swept paths that the figure shows and the caption leaves out.
    """
    known = results.parameters()
    known = known.loc[known.index.intersection(list(rows["job"]))]
    units = SMALL | dict(results.plan["units"])
    said = [*_defects(known, drawn, units), *_machine(known, drawn, units)]
    return [*said, "quick grid"] if results.plan["quick"] else said


def band_of_record(results: "Results", rows: "pd.DataFrame", features: Sequence[str]) -> list[str]:
    """`RMS and peak of 0 to 4.1 kHz`: the band of the statistics that a figure draws, where all rows have one."""
    drawn = [word for word in STATISTICS if any(name.endswith(f".{word}") for name in features)]
    known = results.parameters()
    known = known.loc[known.index.intersection(list(rows["job"]))]
    sampling, filtered = (_single(known, name) for name in ("sampling", "antialias"))
    if not drawn or not isinstance(sampling, float) or filtered is None:
        return []
    if filtered != "true":
        return [f"{' and '.join(STATISTICS[word] for word in drawn)} of raw samples"]
    return [f"{' and '.join(STATISTICS[word] for word in drawn)} of 0 to {FLAT * sampling / 1e3:.2g} kHz"]


def moved_along(figure: "Figure", rows: "pd.DataFrame", units: Mapping[str, str]) -> Iterator[str]:
    """What varies in a completed figure and stands on none of its axes, curves and panels, with its range.

    Of a `zip`, or derived: `load moves along: 150 to 300 N`, with x or with what is named.
    """
    for path, leader in select.moving_along(figure, rows, units):
        with_it = "" if leader in ("", *figure.x.split(", ")) else f" with {labels.name_text(leader)}"
        yield f"{labels.name_text(path)} moves along{with_it}: {_range(path, rows, units)}"


def varying(figure: "Figure", rows: "pd.DataFrame", units: Mapping[str, str]) -> Iterator[str]:
    """What varies in a figure of points and stands on none of its axes and panels: `load varies: 150 to 300 N`.

    In a design nothing follows x, and hardly a point has the x of another.
    """
    for path, _ in select.moving_along(figure, rows, units):
        yield f"{labels.name_text(path)} varies: {_range(path, rows, units)}"


def _range(path: str, rows: "pd.DataFrame", units: Mapping[str, str]) -> str:
    """`150 to 300 N`; words one by one."""
    found = select.values(rows, path)
    if select.is_numeric(found):
        unit = labels.unit_of(path, units)
        low, high = (labels.shown(path, value, unit) for value in (found[0], found[-1]))
        return f"{low:.4g} to {high:.4g}{'' if unit in ('deg', '') else ' '}{labels.pretty(unit)}"
    told = [labels.value_text(path, value, units) for value in found]
    return " / ".join(told if len(told) <= MOST_WORDS else [*told[:MOST_WORDS], f"{len(told) - MOST_WORDS} more"])


def _machine(known: "pd.DataFrame", drawn: set[str], units: Mapping[str, str]) -> Iterator[str]:
    for path, word in CAPTION_FIELDS:
        value = _single(known, path)
        if value is not None and value != USUAL.get(path) and path not in drawn:
            yield f"{word} {labels.value_text(path, value, units)}".strip()


def _defects(known: "pd.DataFrame", drawn: set[str], units: Mapping[str, str]) -> Iterator[str]:
    """Each defect's fixed values, as `circular defect, width 0.8 mm, depth 0.05 mm`."""
    count = len({name.split(".")[1] for name in known.columns if name.startswith("defects.")})
    for number in range(1, count + 1):
        for part in DEFECT:
            names = {f"defect.{part}", f"defects.{number}.{part}"}
            value = _single(known, f"defects.{number}.{part}")
            if value is not None and not names & drawn and (part, value) != ("offset", 0.0):
                shown = units if not names & units.keys() else {f"defect.{part}": units[min(names & units.keys())]}
                text = labels.value_text(f"defect.{part}", value, shown)
                which = f" {number}" if count > 1 else ""
                yield f"{text} defect{which}{_place(known, number)}" if part == "shape" else _sized(part, text)


def _sized(part: str, text: str) -> str:
    """`depth 0.05 mm`; a file without its folder."""
    return f"{part.replace('.', ' ')} {PurePath(text).name if part == 'file' else text}"


def _place(known: "pd.DataFrame", number: int) -> str:
    """Where a defect is, if that is not the outer race."""
    race, roller = (_single(known, f"defects.{number}.{name}") for name in ("race", "roller"))
    if race == "roller":
        return f" of roller {labels.number_text(float(str(roller)))}" if roller is not None else " of a roller"
    return " of the inner race" if race == "inner" else ""


def _single(known: "pd.DataFrame", path: str) -> object:
    """The value that a parameter has in all jobs; None if it varies or is not set."""
    if path not in known or known[path].isna().any() or known[path].nunique() != 1:
        return None
    return known[path].iloc[0] or (0.0 if known[path].dtype.kind == "f" else None)
