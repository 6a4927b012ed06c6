"""Descriptions of the keys of a study, which only the JSON schema needs.

The description of a section's field is the docstring below it, which is read from the source when the schema is
built; pydantic's `use_attribute_docstrings` would read it on import, which delays every command by 0.06 s.
"""

import ast
import inspect
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from types import ModuleType

from bearingsim.config.fields import Section

STUDY_KEYS = {
    "study": "Name of the study, and of its results folder: letters, digits, - _ .",
    "defect": "The defect of a bearing with a single one; `defects` lists several.",
    "accuracy": (
        "Largest difference of the results from those of the reference model. The cheapest model within it "
        "is chosen for each case."
    ),
    "sweep": "Values of keys that vary: all combinations, values varied together (`zip`), or points of a design.",
    "figures": "Figures that `bearingsim plot` draws. Default: one for each swept parameter.",
    "uncertainty": "Other values of uncertain parameters, for which cases are repeated; they give error bands.",
    "measured": "Measured features, or signals, for comparison with the simulated ones; no job changes.",
    "quick": "Keys that `--quick` changes, for a short first run.",
}
"""Descriptions of the keys of a study apart from those of a case."""
SWEEP_KEYS = {
    "zip": "Values that vary together, entry by entry; a list of mappings gives several groups.",
    "derived": "Values computed from other values by a formula, such as `defect.width / 16`.",
    "where": "Conditions on the combinations; only those that satisfy all are computed.",
    "repeat": "Number of runs of each case, each with another seed.",
    "sobol": "Design of Sobol' points; it can be extended by a larger `n`.",
    "lhs": "Design by Latin hypercube sampling.",
    "saltelli": "Design for Sobol' sensitivity indices.",
    "morris": "Design for Morris effects.",
}
DESIGN_KEYS = {
    "n": "Number of points of the design, or of its blocks (`saltelli`) or trajectories (`morris`).",
    "seed": "Seed of the design.",
    "over": "Ranges of the parameters: two bounds, or a distribution between them.",
}
ACCURACY_KEYS = {
    "within": "Largest relative difference from the reference model.",
    "of": "Features to which the accuracy applies. Default: those in the figures.",
}
MEASURED_KEYS = {
    "points": "Table of parameters and features, with units in its header; or a list of rows.",
    "signals": "Files of signals, with the parameters at which they were measured.",
    "label": "Name in legends and tables. Default: the name of the table.",
    "scale": "`true`: measured values times one factor, the median ratio of simulated to measured features.",
}
SIGNAL_KEYS = {
    "file": "File of a signal: csv, lvm, wav, mat, npz, parquet, h5, uff or tdms.",
    "at": "Parameters at which the signal was measured, by path.",
    "rate": "Sampling rate. Default: from the file.",
    "speed": "Speed of the shaft. Default: from the file, else that of the study.",
    "unit": "Unit of the samples. Default: from the file.",
    "channel": "Channel, if the file has several.",
    "full_scale": "Largest value of integer samples (wav), in `unit`.",
}
UNCERTAINTY_KEYS = {
    "damping": "Values of the damping time c/k of the contacts.",
    "clearance": "Values of the radial clearance.",
    "bracket": "Factors on the stiffness of the support of the outer ring.",
    "support": "`unknown`: several load paths into a flexible outer ring.",
    "form": "Height, from peak to valley, of random waviness of both races: three samples.",
    "shaft": "Values of the stiffness of the support of the inner ring, for cases with a `shaft`.",
    "ring_mass": "Values of the mass of the outer ring.",
    "edge": "Values of the edge radius of all defects.",
}


def field_descriptions(section: type[Section]) -> dict[str, str]:
    """Return the description of each field of a section; empty if the source of its module is missing.

    A field without a docstring of its own has that of the parent class; `law` has the section's docstring.
    """
    owners = [owner for owner in reversed(section.__mro__) if issubclass(owner, Section) and owner is not Section]
    texts = {name: text for owner in owners for name, text in _docstrings(owner)}
    if "law" in section.model_fields and section.__doc__:
        texts["law"] = section.__doc__.partition("\n\n")[0]
    return {name: " ".join(text.split()) for name, text in texts.items() if name in section.model_fields}


def _docstrings(owner: type) -> Iterator[tuple[str, str]]:
    """Yield the name and the docstring of each documented field of a class."""
    for statement, following in pairwise(_classes(inspect.getmodule(owner)).get(owner.__name__, ())):
        match statement, following:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str() as text)):
                yield name, text


@cache
def _classes(module: ModuleType | None) -> dict[str, list[ast.stmt]]:
    """Return the bodies of the classes of a module by name; empty without its source."""
    try:
        tree = ast.parse(inspect.getsource(module)) if module else ast.Module([], [])
    except (OSError, TypeError):
        return {}
    return {node.name: node.body for node in tree.body if isinstance(node, ast.ClassDef)}
