"""Types of entries of the catalogue: plain data, and the location of the code."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Model:
    """A model of the bearing.

    module: defines ``KIND`` (``core/models/interface.py``); abilities: effects that it covers
    (``config/rules/hierarchy.py`` lists the keys that require each); slips: rollers and cage move freely and can
    slip; sliced: rollers are divided into slices, and tilt; memoryless: quasi-static, each instant independent of
    the others; repeats: the equations are periodic with the ball pass except for terms that a case switches on,
    and the coordinates are the whole state, so the response may be periodic (``simulation/repetition.py``);
    own_method: the module of its integrator, if the model is no differential equation; build:
    ``build(case, support)`` assembles its parameters, if not field by field (``assemble/__init__.py``).
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
        """True if the rollers carry load: the model starts from their static equilibrium."""
        return "forces" in self.abilities

    @property
    def takes_defects(self) -> bool:
        """True if the rollers roll over defects; otherwise a defect is a series of impulses in time."""
        return "shapes" in self.abilities

    @property
    def has_inertia(self) -> bool:
        """True if the rollers have mass."""
        return "roller inertia" in self.abilities

    @property
    def has_centrifugal_load(self) -> bool:
        """True if the model includes the centrifugal load of the rollers: with roller mass, or quasi-static."""
        return self.has_inertia or (self.loaded and self.memoryless)


@dataclass(frozen=True)
class Method:
    """A time integrator.

    module: defines ``KIND`` (``core/methods/interface.py``); tolerance: default relative tolerance of an adaptive
    method; implicit: solves with the Jacobian of model and laws; automatic: a candidate of `method: auto`.
    """

    name: str
    module: str
    tolerance: float | None = None
    implicit: bool = False
    automatic: bool = False

    @property
    def adaptive(self) -> bool:
        """True if the method adapts its step to an error estimate."""
        return self.tolerance is not None


@dataclass(frozen=True)
class Law:
    """A contact law; ``what``: `stiffness`, `damping` or `friction`.

    section: the class of its parameters in a study file, empty for a law without any; build: the function that
    makes the core's law (arguments: ``assemble/contacts.py``, ``assemble/free.py``); bare: the name alone is valid
    in a study file, with default parameters; element: `roller` or `ball` if the law applies to one of them only,
    else empty; material: the law depends on the elastic constants of the bearing's material.
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
    """A shape of defects.

    build: makes the depth map from length, width and depth (m), or from the whole section if ``of_section``;
    simple: every excitation has a closed form for this shape.
    """

    name: str
    build: str
    simple: bool = False
    of_section: bool = False


@dataclass(frozen=True)
class Feature:
    """A scalar that another package computes from each record.

    unit: SI, or empty; long_name: an axis label; compute: ``compute(case, time, series)`` returns the value;
    ``time`` (n,) in s, ``series``: the recorded arrays (n,) by name, in SI.
    """

    name: str
    unit: str
    long_name: str
    compute: str


Entry = Model | Method | Law | Shape | Feature


def references(entry: Entry) -> list[str]:
    """Return the locations of the code of an entry."""
    named = (getattr(entry, name, "") for name in ("module", "own_method", "section", "build", "compute"))
    return [reference for reference in named if reference]
