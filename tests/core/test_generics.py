"""Every generic function has an implementation for every type that can be passed to it.

Families of types are not listed, but derived: generics with a common type form a family, whose types are all those
that one of them is implemented for. Intentional gaps are in ``EXCEPTIONS``.
"""

import importlib
import pkgutil
from typing import Any

import pytest

import bearingsim.core
from bearingsim.core import jit
from bearingsim.core.advance import Monitor, NoSamples, Samples
from bearingsim.core.defects.closed_forms import section_parameters
from bearingsim.core.defects.crossings import count_crossings
from bearingsim.core.defects.depth import (
    EasedDefect,
    Elliptical,
    MergedDefects,
    MirroredDefect,
    ScannedDefect,
    ShiftedDefect,
)
from bearingsim.core.defects.excitations import TracedPath, defect_response_gradient, response_groups
from bearingsim.core.defects.jumps import next_jump
from bearingsim.core.defects.on_roller import roller_at_defect
from bearingsim.core.defects.spall import Spall
from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.laws.friction.curves import Frictionless, StaticDynamic
from bearingsim.core.laws.stiffness.interface import elastic
from bearingsim.core.laws.stiffness.series import as_power
from bearingsim.core.methods.adaptive import complete_dense_output, estimate_order, failure_outcome, jump_weight
from bearingsim.core.methods.equilibrium import Equilibrium
from bearingsim.core.methods.impulses import Impulses
from bearingsim.core.methods.interface import attempt, interpolate, prepare, reach, stability_ratio, step
from bearingsim.core.methods.symplectic_euler import SymplecticEuler
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.bodies_in_space import Bodies
from bearingsim.core.models.by_roller import (
    NoUpdate,
    accelerate_roller,
    accelerate_shared,
    drift,
    kick,
    load_roller,
    shared_quantities,
)
from bearingsim.core.models.differences import accelerate_bodies, is_free_coordinate
from bearingsim.core.models.impulse import Impulse
from bearingsim.core.models.interface import accelerations, degrees_of_freedom, linearise
from bearingsim.core.models.outer_ring import RingMotion
from bearingsim.core.models.planar import Planar, PlanarMotion
from bearingsim.core.models.ring import Ring
from bearingsim.core.models.rollers import Rollers
from bearingsim.core.models.spatial import Spatial
from bearingsim.core.models.static import Static
from bearingsim.core.parts.bending import Bending, NoSprings, RigidRing, Springs
from bearingsim.core.parts.cage import Centred, FreeCage, KinematicCage, NoDrag, OilDrag, RingGuided
from bearingsim.core.parts.cage_in_space import CageInPlane, CageInSpace
from bearingsim.core.parts.flanges import Flanges, NoFlanges, RollerInRing
from bearingsim.core.parts.form import (
    Form,
    Race,
    Smooth,
    UnequalRollers,
    WavyRollers,
    add_roller_recesses,
    fill_race_recesses,
    locate_on_race,
    locate_on_roller,
)
from bearingsim.core.parts.mounts import ElasticMount, RigidMount, set_mounted_ring
from bearingsim.core.parts.shaft import (
    ElasticShaft,
    FixedRing,
    RigidShaft,
    TorsionSpring,
    accelerance,
    accelerate_inner_ring,
    accelerate_ring_rotation,
)

Registry = dict[Any, frozenset[type]]
"""Generics and the types that each is implemented for."""

MODULES = [
    importlib.import_module(module.name)
    for module in pkgutil.walk_packages(bearingsim.core.__path__, "bearingsim.core.")
]
BY_ROLLER = (shared_quantities, load_roller, accelerate_shared, accelerate_roller)
ADAPTIVE = (attempt, interpolate, reach, estimate_order, failure_outcome, jump_weight, complete_dense_output)


def package_types(types: Any) -> frozenset[type]:
    """Return the types defined in the package, not in tests."""
    return frozenset(kind for kind in types if kind.__module__.startswith("bearingsim."))


REGISTRY: Registry = {
    generic: package_types(generic.types)
    for generic in jit.GENERICS
    if generic.__module__.startswith("bearingsim.")
}
FIXED_STEP_METHODS = REGISTRY[step].difference(*(REGISTRY[generic] for generic in ADAPTIVE))
COUNTERPARTS: dict[type, type] = {
    Frictionless: StaticDynamic,
    RigidShaft: ElasticShaft,
    FixedRing: TorsionSpring,
    RigidMount: ElasticMount,
    NoFlanges: Flanges,
    KinematicCage: FreeCage,
    CageInPlane: CageInSpace,
    Centred: RingGuided,
    NoDrag: OilDrag,
    NoSamples: Samples,
    NoUpdate: Verlet,
    RigidRing: Bending,
    NoSprings: Springs,
    Smooth: Form,
}
"""Absent types, and a type of the family of each; some absent types need no implementation."""

EXCEPTIONS: list[tuple[tuple[Any, ...], Any, str]] = [
    ((response_groups,), {TracedPath}, "its groups are made with its table, from paths: `defects/traced.py`"),
    (
        (section_parameters,),
        {Elliptical, EasedDefect, MirroredDefect, ShiftedDefect, MergedDefects, Spall, ScannedDefect},
        "their paths are traced",
    ),
    ((roller_at_defect,), {Impulse}, "it has no contacts, so no roller is located at a defect"),
    (
        (accelerations, degrees_of_freedom, linearise, next_jump),
        {Static, Impulse},
        "`Equilibrium`, `Impulses` step them",
    ),
    (BY_ROLLER, {Static, Impulse, Spatial}, "they have no accelerations, or roll by slices"),
    ((prepare,), {Equilibrium, Impulses}, "they evaluate no accelerations, and start from the state alone"),
    (
        (accelerate_bodies, is_free_coordinate),
        {Static, Impulse, Ring, Rollers, Planar},
        "their derivatives are exact, or not needed",
    ),
    (ADAPTIVE, FIXED_STEP_METHODS, "`adaptive.py` does not drive them"),
    (
        (*ADAPTIVE, step, prepare, stability_ratio),
        {NoUpdate},
        "it is a placeholder for a method, without steps of its own",
    ),
    ((drift, kick), REGISTRY[step] - {Verlet, SymplecticEuler}, "their stages are more than a drift and a kick"),
    ((accelerate_inner_ring,), {TorsionSpring}, "a bracket supports the outer ring"),
    ((accelerate_ring_rotation,), {ElasticShaft}, "a shaft carries the inner ring"),
    ((fill_race_recesses, locate_on_race), {WavyRollers, UnequalRollers}, "races only"),
    ((add_roller_recesses, locate_on_roller), {Race}, "rollers only"),
]
"""Generics, types without implementation, reason."""

WITHOUT_GENERICS = {RollerInRing, Bodies, Monitor, PlanarMotion, RingMotion}
"""Tuples that no generic dispatches on, in modules with types of a family."""


class UnknownType:
    """Type without any registration."""


@jit.absent
class AbsentType:
    """Absent type without any registration."""


def excepted_types(generic: Any) -> set[type]:
    return {kind for generics, types, _ in EXCEPTIONS if generic in generics for kind in types}


def types_with_default(generic: Any, types: frozenset[type]) -> set[type]:
    """Return the types that need no implementation: all if the generic has a default, else the absent types."""
    absent_types = jit.ABSENT if generic.supports(AbsentType) else set()
    return {kind for kind in types if generic.supports(UnknownType) or kind in absent_types}


def with_counterparts(types: frozenset[type]) -> frozenset[type]:
    """Return the types with their absent counterparts, and absent types with their counterparts."""
    return types.union(*(pair for pair in COUNTERPARTS.items() if types.intersection(pair)))


def families(registry: Registry) -> list[tuple[list[Any], frozenset[type]]]:
    """Group generics with common types into families; return generics and types of each."""
    merged: list[tuple[list[Any], frozenset[type]]] = []
    for generic, types in ((generic, with_counterparts(types)) for generic, types in registry.items()):
        related = [family for family in merged if family[1] & types]
        merged = [family for family in merged if not family[1] & types]
        members = [generic, *(member for family in related for member in family[0])]
        merged.append((members, types.union(*(family[1] for family in related))))
    return merged


def is_tuple(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, tuple) and hasattr(kind, "_fields")


def missing_implementations(registry: Registry) -> list[str]:
    """List missing implementations, and exceptions that are not needed."""
    messages = []
    for generics, types in families(registry):
        for generic in generics:
            lacking, exceptions = (
                types - registry[generic] - types_with_default(generic, types),
                excepted_types(generic),
            )
            messages += [f"{generic.__name__} has none for {kind.__name__}" for kind in lacking - exceptions]
            messages += [
                f"{generic.__name__} needs no exception of {kind.__name__}" for kind in exceptions - lacking
            ]
    return messages


def types_without_generic(registry: Registry) -> set[type]:
    """Return the types in no family: tuples in a module with types of a family, and absent types."""
    covered = frozenset().union(*(types for _, types in families(registry)))
    modules = {kind.__module__ for kind in covered}
    tuples = {kind for module in MODULES for kind in vars(module).values() if is_tuple(kind)}
    neighbours = {kind for kind in tuples if kind.__module__ in modules}
    return ((neighbours - WITHOUT_GENERICS) | package_types(jit.ABSENT)) - covered


def faults(registry: Registry) -> list[str]:
    """List all faults of a registry as messages."""
    empty = [f"{generic.__name__} has no implementation" for generic, types in registry.items() if not types]
    return (
        empty
        + missing_implementations(registry)
        + [f"no generic is chosen by {kind.__name__}" for kind in types_without_generic(registry)]
    )


def test_all_generics_are_complete() -> None:
    assert faults(REGISTRY) == []


def test_every_missing_implementation_is_reported() -> None:
    """Generics with a default are left out."""
    pairs = [
        (generic, kind)
        for generic, types in REGISTRY.items()
        for kind in types
        if not generic.supports(UnknownType)
    ]
    unreported = [
        (generic.__name__, kind.__name__)
        for generic, kind in pairs
        if not faults(REGISTRY | {generic: REGISTRY[generic] - {kind}})
    ]
    assert unreported == []
    assert len(pairs) > 290


@pytest.mark.parametrize(
    ("generic", "kind"), [(defect_response_gradient, TracedPath), (set_mounted_ring, RigidMount)]
)
def test_report_names_generic_and_type(generic: Any, kind: type) -> None:
    report = faults(REGISTRY | {generic: REGISTRY[generic] - {kind}})
    assert report == [f"{generic.__name__} has none for {kind.__name__}"]


def test_new_type_needs_all_generics_of_its_family() -> None:
    class New:
        pass

    messages = faults(REGISTRY | {normal_force: REGISTRY[normal_force] | {New}})
    others = (damping_bound, derivatives, stiffness_bound)
    assert sorted(messages) == sorted(f"{generic.__name__} has none for New" for generic in others)


@pytest.mark.parametrize(
    ("generic", "other"),
    [
        (normal_force, derivatives),
        (accelerance, accelerate_ring_rotation),
        (count_crossings, linearise),
        (elastic, as_power),
    ],
)
def test_generics_are_grouped_into_families(generic: Any, other: Any) -> None:
    (family,) = (generics for generics, _ in families(REGISTRY) if generic in generics)
    assert other in family
    assert defect_response_gradient not in family
