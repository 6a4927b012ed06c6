"""Kinds of entries of the catalogue: words and numbers, and where the code of each stands."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Model:
    """A model of the bearing.

    module: holds its ``KIND`` (``core/models/interface.py``); abilities: what a case can ask of it
    (``config/rules/hierarchy.py`` says what asks for what); slips: rollers and cage move freely and can slip;
    sliced: rollers are cut into slices, and tilt; memoryless: each instant stands alone; repeats: nothing in it
    changes from ball pass to ball pass but what a case's fields say, and its whole state lies in its coordinates,
    so its motion may repeat itself (``simulation/repetition.py``); own_method: the module of the only way to step
    it, if it is no differential equation; build: ``build(case, support)`` makes its parameters, if they are not
    made field by field (``assemble/__init__.py``).
    """

    name: str
    module: str
    abilities: frozenset[str]
    slips: bool = False
    sliced: bool = False
    memoryless: bool = False
    repeats: bool = False
    own_method: str = ""
    build: str = ""

    @property
    def loaded(self) -> bool:
        """Whether its rollers carry load: it starts from their static equilibrium."""
        return "forces" in self.abilities

    @property
    def takes_pits(self) -> bool:
        """Whether its rollers roll over pits; else a defect is impulses in time."""
        return "shapes" in self.abilities

    @property
    def has_inertia(self) -> bool:
        """Whether its rollers have mass."""
        return "roller inertia" in self.abilities

    @property
    def has_centrifugal_load(self) -> bool:
        """Whether its rollers press outwards as they go round: those with mass, and those at rest each instant."""
        return self.has_inertia or (self.loaded and self.memoryless)


@dataclass(frozen=True)
class Method:
    """A way to integrate.

    module: holds its ``KIND`` (``core/methods/interface.py``); tolerance: its usual one, relative, if it chooses
    its steps by an estimate of their error; implicit: it solves with the derivatives of model and laws; automatic:
    `method: auto` may choose it.
    """

    name: str
    module: str
    tolerance: float | None = None
    implicit: bool = False
    automatic: bool = False

    @property
    def adaptive(self) -> bool:
        """Whether it chooses its own steps."""
        return self.tolerance is not None


@dataclass(frozen=True)
class Law:
    """A law of ``what``: `stiffness`, `damping` or `friction`.

    section: the class of its numbers in a study file, empty for a word without numbers; build: the function that
    makes the core's law (``assemble/contacts.py`` and ``assemble/free.py`` say from what); bare: its name alone
    may stand in a study file, its numbers taking their defaults; element: whose contact it is, `roller` or `ball`,
    or empty; material: the elastic constants of the bearing's material enter it.
    """

    name: str
    what: str
    section: str
    build: str
    bare: bool = False
    element: str = ""
    material: bool = True


@dataclass(frozen=True)
class Shape:
    """A shape of pits.

    build: makes its depth map of length, width and depth (m), or of the whole section if ``of_section``;
    simple: every excitation has a closed form for it.
    """

    name: str
    build: str
    simple: bool = False
    of_section: bool = False


@dataclass(frozen=True)
class Feature:
    """A number that another package reads from each record.

    unit: SI, or empty; long_name: an axis label; compute: ``compute(case, time, series)`` gives the number, with
    ``time`` (n,) in s and ``series`` the recorded arrays (n,) by name, in SI.
    """

    name: str
    unit: str
    long_name: str
    compute: str


Entry = Model | Method | Law | Shape | Feature


def places(entry: Entry) -> list[str]:
    """Return where the code of an entry stands."""
    named = (getattr(entry, name, "") for name in ("module", "own_method", "section", "build", "compute"))
    return [place for place in named if place]
