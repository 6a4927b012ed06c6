"""Spectral lines of a defect, given by the element that carries it."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.catalogue import MODELS
from bearingsim.config.names import Line

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd


class Family(NamedTuple):
    """Lines of one element: name and frequency of the fundamental, spacing of the sidebands and its name."""

    line: str
    fundamental: Line
    modulation: Line | None = None
    spacing_name: str = ""

    def name(self, k: int) -> str:
        """Return the name of the k-th line: `BPFO`, `3 BPFO`; of rollers `2 BSF`, `6 BSF`."""
        step, word = (2, "BSF") if self.fundamental.spin else (1, self.line)
        return f"{k * step} {word}" if k * step > 1 else word


SHAFT = Line(shaft=1)
FAMILIES = {
    "outer": Family("BPFO", Line(outer=1)),
    "inner": Family("BPFI", Line(inner=1), Line(shaft=1), "fr"),
    "roller": Family("2BSF", Line(spin=2), Line(cage=1), "FTF"),
}
"""Families of lines by the element that carries the defect, whose rotation through the load zone causes the
sidebands."""


class Mark(NamedTuple):
    """Line on the frequency axis: its frequency (Hz), element with the defect, name, and number of the harmonic.

    side: -1 or 1 for a sideband, 0 for a harmonic. Number 0 marks the spacing of the sidebands itself.
    """

    frequency: float
    race: str
    name: str
    number: int
    side: int = 0


def races(*jobs: Mapping[Any, Any]) -> list[str]:
    """List the elements with defects in some jobs, from their parameters; empty for healthy bearings."""
    elements = {
        value
        for parameters in jobs
        for name, value in parameters.items()
        if str(name).startswith("defects.") and str(name).endswith(".race")
    }
    return [race for race in FAMILIES if race in elements]


def races_of_all(parameters: "pd.DataFrame") -> list[str]:
    """List the elements with defects over a table of parameters."""
    return races(*parameters.filter(regex=r"\.race$").drop_duplicates().to_dict("records"))


def fundamental_lines(parameters: "pd.DataFrame") -> list[str]:
    """List the fundamental line of each family present in some jobs; BPFO for healthy bearings."""
    return [FAMILIES[race].line for race in races_of_all(parameters) or ("outer",)]


def may_slip(parameters: "pd.DataFrame") -> bool:
    """Check if the model of any job has cage slip."""
    free = [model.name for model in MODELS.values() if model.slips]
    return "model" in parameters and bool(parameters["model"].isin(free).any())


def frequency(line: Line, parameters: Mapping[Any, Any]) -> float:
    """Compute the frequency (Hz) of a line without cage slip from the parameters of a job."""
    from math import pi

    from bearingsim.core.geometry.kinematics import ball_spin_frequency, fundamental_train_frequency

    omega, D_w, d_m = (parameters[name] for name in ("speed", "bearing.roller_diameter", "bearing.pitch_diameter"))
    Z, shaft = int(parameters["bearing.rollers"]), omega / (2.0 * pi)
    cage = fundamental_train_frequency(omega, D_w, d_m)
    spin = ball_spin_frequency(omega, D_w, d_m)
    return float(line.frequency(Z * cage, Z * (shaft - cage), spin, cage, shaft))


def speeds(parameters: Mapping[Any, Any], info: Mapping[Any, Any], time: "np.ndarray") -> "np.ndarray":
    """Return the speed (rad/s) of the inner ring of a job at the times (n,) of its record (s).

    A ramp begins with the settling time, after which the record begins. info: attributes set by the solver, which
    contain that time.
    """
    import numpy as np

    initial, final = float(parameters["speed"]), float(parameters.get("ramp.to", np.nan))
    if np.isnan(final):
        return np.full(len(time), initial)
    share = (float(info["settle_s"]) + time) / float(parameters["ramp.time"])
    return initial + (final - initial) * np.clip(share, 0.0, 1.0)


def frequencies(line: Line, parameters: "pd.DataFrame") -> list[float]:
    """Compute the distinct frequencies (Hz) of a line in some jobs without cage slip; for ramps, at both ends."""
    names = ["speed", "bearing.roller_diameter", "bearing.pitch_diameter", "bearing.rollers"]
    cases = parameters[names].drop_duplicates().to_dict("records")
    if "ramp.to" in parameters:
        ends = parameters.dropna(subset="ramp.to")
        cases += ends[names].assign(speed=ends["ramp.to"]).drop_duplicates().to_dict("records")
    return list(dict.fromkeys(frequency(line, case) for case in cases))


def marks(parameters: Mapping[Any, Any], highest: float) -> Iterator[Mark]:
    """Yield the harmonics, sidebands and sideband spacings up to ``highest`` (Hz) of a job's defects."""
    for race in races(parameters) or ["outer"]:
        yield from (mark for mark in _family_marks(race, parameters, highest) if mark.frequency <= highest)


def _family_marks(race: str, parameters: Mapping[Any, Any], highest: float) -> Iterator[Mark]:
    """Yield the lines of one element: all up to ``highest`` (Hz), and some above it."""
    family = FAMILIES[race]
    fundamental = frequency(family.fundamental, parameters)
    spacing = frequency(family.modulation, parameters) if family.modulation else 0.0
    if family.modulation:
        yield Mark(spacing, race, family.spacing_name, 0, side=1)
    for k in range(1, int((highest + spacing) / fundamental) + 1):  # the last lower sideband may be below
        yield Mark(k * fundamental, race, family.name(k), k)
        if family.modulation:
            for sign, side in (("-", -1), ("+", 1)):
                name = f"{family.name(k)} {sign} {family.spacing_name}"
                yield Mark(k * fundamental + side * spacing, race, name, k, side)
