"""Catalogue of models, methods, contact laws, shapes of defects and features: one table for each kind.

An entry (``entries.py``) is plain data: the name used in study files, the abilities, and the location of the code
(``package.module`` or ``package.module:name``), which is imported on first use. All other packages look up models
and methods in these tables.

Another package registers its own entries in the module to which its entry point refers:

    # pyproject.toml of the other package:  [project.entry-points."bearingsim.extensions"]
    #                                       mine = "my_package"
    # my_package/__init__.py
    from bearingsim.catalogue import Law, register

    register(Law("viscous", "damping", "my_package.viscous:Viscous", "my_package.viscous:build"))

docs/extending.md describes what the module of each kind must define. Compiled code is cached separately for each
set of extensions (``extension_sources``).
"""

import hashlib
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from bearingsim import extensions
from bearingsim.cpu_time import OutOfCpuTime
from bearingsim.entries import Entry, Feature, Law, Method, Model, Shape, references
from bearingsim.errors import Refused, UserError
from bearingsim.extensions import BrokenExtension

__all__ = [
    "AUTO",
    "DEFAULT_MODEL",
    "EXPLICIT",
    "FEATURES",
    "LAWS",
    "METHODS",
    "MODELS",
    "REFERENCE",
    "REFERENCES",
    "SHAPES",
    "Entry",
    "Feature",
    "Law",
    "Method",
    "Model",
    "Shape",
    "call",
    "code",
    "extension_digest",
    "extension_sources",
    "is_foreign",
    "most_detailed_model",
    "references",
    "register",
    "simpler_models",
    "simplest_model",
]

PACKAGE = "bearingsim"
"""Package of the program's own code."""

REFERENCE, AUTO = "reference", "auto"
"""Reserved names for the automatic choice of the reference model, and of the method."""

MODELS: dict[str, Model] = {}
"""Models in order of increasing detail; those of other packages come last."""
METHODS: dict[str, Method] = {}
LAWS: dict[str, dict[str, Law]] = {"stiffness": {}, "damping": {}, "friction": {}}
SHAPES: dict[str, Shape] = {}
FEATURES: dict[str, Feature] = {}
"""Features of other packages; the program's own are in ``config/names.py``."""


def register(*entries: Entry) -> None:
    """Add entries to the tables.

    Raises ValueError for a reserved or duplicate name, an unknown kind of law, a damping or friction law without a
    section, or an object of another type.
    """
    for entry in entries:
        if not isinstance(entry, Entry):
            raise ValueError(f"expected a Model, Method, Law, Shape or Feature, got `{entry!r}`")
        table = _table_of(entry)
        if entry.name in (REFERENCE, AUTO):
            raise ValueError(f"`{entry.name}` is reserved for automatic choice; use another name")
        if isinstance(entry, Law) and not entry.section and entry.what != "stiffness":
            raise ValueError(f"the {entry.what} law `{entry.name}` needs a section")
        if entry.name in table:
            raise ValueError(f"`{entry.name}` is already registered; use another name")
        table[entry.name] = entry


def _table_of(entry: Entry) -> dict[str, Any]:
    match entry:
        case Model():
            return MODELS
        case Method():
            return METHODS
        case Shape():
            return SHAPES
        case Feature():
            return FEATURES
        case Law(what=what) if what in LAWS:
            return LAWS[what]
    raise ValueError(f"expected a law of {', '.join(LAWS)}, got `{entry.what}`")


def is_foreign(reference: str) -> bool:
    """Return True if the code of a reference belongs to another package."""
    return extensions.package(reference) != PACKAGE


def code(reference: str, expected: type = object) -> Any:
    """Import and return the object at ``package.module`` or ``package.module:name``.

    Raises UserError if the import fails or the object is not of the expected type; BrokenExtension (a UserError)
    if the code belongs to an extension.
    """
    module, _, name = reference.partition(":")
    try:
        loaded = import_module(module)
        loaded = getattr(loaded, name) if name else loaded
    except (Exception, SystemExit) as error:  # any failure of another package
        raise _make_error(reference, f"does not load ({extensions.reason(error)})") from error
    if not isinstance(loaded, expected):
        raise _make_error(reference, f"is of type {type(loaded).__name__}, not {expected.__name__}")
    return loaded


def call(reference: str, *arguments: Any) -> Any:
    """Call the function at ``reference``, and return its result.

    Raises the errors of ``code``. UserError, Refused and OutOfCpuTime are raised unchanged, and so is any error of
    the program's own functions; other errors of an extension become BrokenExtension.
    """
    function = code(reference)
    try:
        return function(*arguments)
    except (UserError, Refused, OutOfCpuTime):
        raise
    except (Exception, SystemExit) as error:
        if not is_foreign(reference):
            raise
        raise _make_error(reference, f"fails ({extensions.reason(error)})") from error


def _make_error(reference: str, reason: str) -> UserError:
    if not is_foreign(reference):
        return UserError(f"`{reference}` {reason}")
    return BrokenExtension(f"`{reference}` of the extension `{extensions.owner(reference)}` {reason}")


def simpler_models(name: str) -> list[str]:
    """Return the models less detailed than ``name`` whose rollers carry load, in order of decreasing detail."""
    names = list(MODELS)
    return [simpler for simpler in reversed(names[: names.index(name)]) if MODELS[simpler].loaded]


def simplest_model(*abilities: str) -> str:
    """Return the name of the simplest model with all these abilities."""
    return next(model.name for model in MODELS.values() if model.abilities.issuperset(abilities))


def most_detailed_model() -> str:
    """Return the name of the model with the most abilities."""
    return max(MODELS.values(), key=lambda model: len(model.abilities)).name


# Entries of the program

_STATIC = frozenset({"balance", "forces", "a second load", "shapes", "balls", "form"})
_RING = _STATIC | {"damping", "acceleration", "weakened contact", "shared pressure"}
_ROLLERS = _RING | {"roller inertia"}
_PLANAR = _ROLLERS | {"ramp", "gravity", "friction", "cage", "drag", "shaft", "ring rotation", "slip"}
_SPATIAL = _PLANAR - {"balls", "shared pressure"} | {"tilt", "tilting rings", "profile"}

_M, _S, _C, _A = (
    "bearingsim.core.models",
    "bearingsim.core.methods",
    "bearingsim.config.sections",
    "bearingsim.assemble",
)

DESCRIPTIONS = {
    "impulse": "model: a train of impulses excites the outer ring",
    "static": "model: equilibrium of the outer ring at each instant, without inertia",
    "ring": "model: the outer ring moves on massless rollers; the cage rotates at its kinematic speed",
    "rollers": "model: rollers move radially, the outer ring in the plane; the cage rotates at its kinematic "
    "speed, without slip",
    "planar": "model: rollers, cage and outer ring move in the plane, with slip if there is friction",
    "spatial": "model: as planar, with sliced rollers that tilt and skew",
    "palmgren": "contact stiffness: force of a steel line contact, k δ^(10/9) (Palmgren)",
    "iso16281": "contact stiffness: force of a steel line contact by slices, k δ^(10/9) (ISO 16281)",
    "johnson": "contact stiffness: line contact of two elastic cylinders (Johnson)",
    "point": "contact stiffness: elliptical point contact, k δ^(3/2) (Hertz)",
    "kraemer": "contact damping: β times the contact stiffness (Krämer)",
    "hunt-crossley": "contact damping: χ times the contact force (Hunt and Crossley)",
    "film": "contact damping: oil film and hysteresis of the steel",
}
"""Descriptions of models and contact laws for the report, by name; laws without an entry are not explained."""

register(
    Model(
        "impulse",
        f"{_M}.impulse",
        frozenset({"impulses", "acceleration", "balls", "damping"}),
        own_method=f"{_S}.impulses",
        build=f"{_A}.impulses:build_model",
    ),
    Model(
        "static",
        f"{_M}.static",
        _STATIC | {"bending ring"},
        memoryless=True,
        repeats=True,
        own_method=f"{_S}.equilibrium",
    ),
    Model("ring", f"{_M}.ring", _RING, repeats=True),
    Model("rollers", f"{_M}.rollers", _ROLLERS | {"bending ring"}, repeats=True),
    Model("planar", f"{_M}.planar", _PLANAR, slips=True, repeats=True),
    Model("spatial", f"{_M}.spatial", _SPATIAL, slips=True, sliced=True, repeats=True),
    Method("verlet", f"{_S}.verlet", automatic=True),
    Method("dop853", f"{_S}.dop853", tolerance=1e-4, automatic=True),
    Method("rodas", f"{_S}.rodas", tolerance=1e-4, implicit=True, automatic=True),
    Method("backward-euler", f"{_S}.backward_euler", tolerance=1e-5, implicit=True, automatic=True),
    Method("symplectic-euler", f"{_S}.symplectic_euler"),
    Method("rk4", f"{_S}.rk4"),
    Method("dormand-prince", f"{_S}.dormand_prince", tolerance=1e-4, automatic=True),
    Method("nystrom", f"{_S}.nystrom"),
    Method("generalized-alpha", f"{_S}.generalised_alpha", implicit=True),
    Method("velocity-implicit-euler", f"{_S}.velocity_implicit", implicit=True),
    Method("stabilised", f"{_S}.stabilised"),
    Law("palmgren", "stiffness", "", f"{_A}.contacts:build_palmgren", bare=True, element="roller", material=False),
    Law("iso16281", "stiffness", "", f"{_A}.contacts:build_iso16281", bare=True, element="roller", material=False),
    Law(
        "johnson",
        "stiffness",
        "",
        f"{_A}.contacts:build_johnson",
        bare=True,
        element="roller",
        stiff_at_touch_down=True,
    ),
    Law("point", "stiffness", "", f"{_A}.contacts:build_point", bare=True, element="ball"),
    Law("constant", "stiffness", f"{_C}.contact:Constant", f"{_A}.contacts:build_constant", material=False),
    Law("kraemer", "damping", f"{_C}.contact:Kraemer", f"{_A}.contacts:build_kraemer", bare=True, material=False),
    Law(
        "hunt-crossley",
        "damping",
        f"{_C}.contact:HuntCrossley",
        f"{_A}.contacts:build_hunt_crossley",
        bare=True,
        material=False,
    ),
    Law("film", "damping", f"{_C}.contact:Film", f"{_A}.contacts:build_film"),
    Law("loss-factor", "damping", f"{_C}.contact:LossFactor", f"{_A}.contacts:build_kraemer", material=False),
    Law("general", "damping", f"{_C}.contact:General", f"{_A}.contacts:build_general", material=False),
    Law("none", "damping", f"{_C}.contact:Undamped", f"{_A}.contacts:build_kraemer", bare=True, material=False),
    Law("static-dynamic", "friction", f"{_C}.free:StaticDynamic", f"{_A}.free:build_static_dynamic", bare=True),
    Law("traction", "friction", f"{_C}.free:Traction", f"{_A}.free:build_traction", bare=True),
    Law("none", "friction", f"{_C}.free:Frictionless", f"{_A}.free:build_frictionless", bare=True),
    Shape("rectangular", "bearingsim.core.defects.depth:Rectangular", simple=True),
    Shape("triangular", "bearingsim.core.defects.depth:Triangular", simple=True),
    Shape("circular", "bearingsim.core.defects.depth:Circular", simple=True),
    Shape("elliptical", "bearingsim.core.defects.depth:Elliptical"),
    Shape("spall", f"{_A}.defects:build_spall", of_section=True),
    Shape("scan", f"{_A}.defects:build_scan", of_section=True),
)

DEFAULT_MODEL = "rollers"
"""Default model of a case."""
REFERENCES = ("planar", "spatial", "rollers", "impulse")
"""Reference models: a case is compared with the first of these that covers all effects that it requires."""
EXPLICIT = "verlet"
"""Explicit method with whose step limit and cost those of other methods are compared."""


# Entries of other packages


def extension_sources() -> Iterator[Path]:
    """Yield every Python file of the packages with extensions; compiled code and results depend on them."""
    for package in _packages():
        try:
            spec = find_spec(package)
        except (ImportError, ValueError):  # the package is broken, or is a script
            continue
        if spec is not None and spec.submodule_search_locations:
            for folder in spec.submodule_search_locations:
                yield from (path for path in sorted(Path(folder).rglob("*.py")) if path.is_file())
        elif spec is not None and spec.origin:
            yield Path(spec.origin)


def _packages() -> tuple[str, ...]:
    """Return the packages of all extensions, and of the code that they register."""
    tables: tuple[dict[str, Any], ...] = (MODELS, METHODS, SHAPES, FEATURES, *LAWS.values())
    registered = [reference for table in tables for entry in table.values() for reference in references(entry)]
    values = [entry.value for entry in extensions.enabled()]
    return tuple(
        sorted({extensions.package(reference) for reference in (*values, *filter(is_foreign, registered))})
    )


@cache
def extension_digest() -> str:
    """Return the first 12 hex digits of SHA-256 over ``extension_sources``."""
    digest = hashlib.sha256()
    for source in extension_sources():
        digest.update(source.read_bytes())
    return digest.hexdigest()[:12]


extensions.load()
