"""Types of the entries of the catalogue: plain data, and the location of the code."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Model:
    """Model of the bearing.

    module: module that defines ``KIND`` (``core/models/interface.py``); abilities: effects that the model covers
    (``config/rules/hierarchy.py`` lists the keys that require each); slips: rollers and cage move freely and can
    slip; sliced: rollers are divided into slices and can tilt; memoryless: the model is quasi-static; repeats: a
    periodic response can be detected (``simulation/repetition.py``), because the coordinates are the complete
    state and the equations have the period of a ball pass unless the case adds other terms; own_method: module of
    the integrator of a model that is not a differential equation; build: ``build(case, support)`` assembles the
    parameters if they are not assembled field by field (``assemble/__init__.py``).
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
        """True if the rollers carry load, so that the model starts from their static equilibrium."""
        return "forces" in self.abilities

    @property
    def has_defect_geometry(self) -> bool:
        """True if the rollers roll over the shape of a defect; otherwise a defect is a series of impulses."""
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
    """Time integrator.

    module: module that defines ``KIND`` (``core/methods/interface.py``); tolerance: default relative tolerance of
    an adaptive method; implicit: True if the method uses the Jacobian of the model and the laws; automatic: True
    for a candidate of `method: auto`.
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
    """Contact law; what: `stiffness`, `damping` or `friction`.

    section: class of the parameters in a study file, empty for a law without parameters; build: function that
    builds the law of the core (arguments: ``assemble/contacts.py``, ``assemble/free.py``); bare: True if a study
    file may give only the name, with default parameters; element: `roller` or `ball` if the law applies to only
    one of them, else empty; material: True if the law depends on the elastic constants of the bearing's material;
    stiff_at_touch_down: True if the stiffness of a law without parameters does not start from zero.
    """

    name: str
    what: str
    section: str
    build: str
    bare: bool = False
    element: str = ""
    material: bool = True
    stiff_at_touch_down: bool = False


@dataclass(frozen=True)
class Shape:
    """Shape of a defect.

    build: function that builds the depth map from length, width and depth (m), or from the whole section if
    ``of_section``; simple: True if every excitation has a closed form for this shape.
    """

    name: str
    build: str
    simple: bool = False
    of_section: bool = False


@dataclass(frozen=True)
class Feature:
    """Scalar that another package computes from each record.

    unit: SI unit, or empty; long_name: axis label; compute: ``compute(case, time, series)`` returns the value,
    with ``time`` (n,) in s and ``series``, the recorded arrays (n,) in SI by name.
    """

    name: str
    unit: str
    long_name: str
    compute: str


Entry = Model | Method | Law | Shape | Feature


def references(entry: Entry) -> list[str]:
    """Return the locations of the code of an entry."""
    locations = (getattr(entry, name, "") for name in ("module", "own_method", "section", "build", "compute"))
    return [reference for reference in locations if reference]
