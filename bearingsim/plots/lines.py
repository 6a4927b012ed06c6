"""The lines that show a defect: those of the element that carries it."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.catalogue import MODELS
from bearingsim.config.names import Line

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["FAMILIES", "Family", "Mark", "fitting", "frequency", "marks", "may_slip", "races", "races_of_all"]


class Family(NamedTuple):
    """Lines of one element: the first, by how much a name counts up, and the sidebands' distance and its name."""

    line: str
    first: Line
    beside: Line | None = None
    distance: str = ""

    def name(self, k: int) -> str:
        """`BPFO`, `3 BPFO`; of rollers `2 BSF`, `6 BSF`."""
        step, word = (2, "BSF") if self.first.spin else (1, self.line)
        return f"{k * step} {word}" if k * step > 1 else word


FAMILIES = {
    "outer": Family("BPFO", Line(outer=1)),
    "inner": Family("BPFI", Line(inner=1), Line(shaft=1), "fr"),
    "roller": Family("2BSF", Line(spin=2), Line(cage=1), "FTF"),
}
"""By the word that says where a defect is. One that turns through the load zone is felt in its rhythm."""


class Mark(NamedTuple):
    """A place on the frequency axis (Hz): of which race's family, its name, and whether it is a sideband."""

    hertz: float
    race: str
    name: str
    sideband: bool = False


def races(*jobs: Mapping[Any, Any]) -> list[str]:
    """Where the defects of some jobs are, from their parameters; nothing for healthy bearings."""
    found = {
        value
        for known in jobs
        for name, value in known.items()
        if str(name).startswith("defects.") and str(name).endswith(".race")
    }
    return [race for race in FAMILIES if race in found]


def races_of_all(known: "pd.DataFrame") -> list[str]:
    """``races`` of all jobs of a table of parameters."""
    return races(*known.filter(regex=r"\.race$").drop_duplicates().to_dict("records"))


def fitting(known: "pd.DataFrame") -> list[str]:
    """The first line of each family that the defects of some jobs have; of healthy bearings the outer race's."""
    return [FAMILIES[race].line for race in races_of_all(known) or ("outer",)]


def may_slip(known: "pd.DataFrame") -> bool:
    """Whether the cage of some of the jobs can slip."""
    free = [model.name for model in MODELS.values() if model.slips]
    return "model" in known and bool(known["model"].isin(free).any())


def frequency(line: Line, known: Mapping[Any, Any]) -> float:
    """Where a line stands (Hz) if the cage does not slip; ``known``: a job's parameters."""
    from math import pi

    from bearingsim.core.geometry.kinematics import ball_spin_frequency, fundamental_train_frequency

    omega, D_w, d_m = (known[name] for name in ("speed", "bearing.roller_diameter", "bearing.pitch_diameter"))
    Z, shaft = int(known["bearing.rollers"]), omega / (2.0 * pi)
    cage = fundamental_train_frequency(omega, D_w, d_m)
    spin = ball_spin_frequency(omega, D_w, d_m)
    return float(
        line.outer * Z * cage
        + line.inner * Z * (shaft - cage)
        + line.spin * spin
        + line.cage * cage
        + line.shaft * shaft
    )


def marks(known: Mapping[Any, Any], highest: float) -> Iterator[Mark]:
    """The lines up to ``highest`` (Hz) of the families that a job's defects have."""
    for race in races(known) or ["outer"]:
        family = FAMILIES[race]
        first = frequency(family.first, known)
        for k in range(1, int(highest / first) + 1):
            yield Mark(k * first, race, family.name(k))
            if family.beside:
                aside = frequency(family.beside, known)
                for sign, side in (("-", -aside), ("+", aside)):
                    yield Mark(k * first + side, race, f"{family.name(k)} {sign} {family.distance}", sideband=True)
