"""Every generic function has an implementation for every type that can reach it.

Nobody lists the families of types: generics that have a type in common range over the same family, which is all
the types that any of them is implemented for. What is missing on purpose stands in ``EXCEPTIONS``.
"""

import importlib
import pkgutil
from typing import Any

import pytest

import bearingsim.core
from bearingsim.core import jit
from bearingsim.core.advance import Monitor, NoSamples, Samples
from bearingsim.core.defects.closed_forms import section_of
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
    shared,
)
from bearingsim.core.models.differences import accelerate_bodies, is_free_coordinate
from bearingsim.core.models.impulse import Impulse
from bearingsim.core.models.interface import accelerations, degrees_of_freedom, linearise
from bearingsim.core.models.outer_ring import RingMotion
from bearingsim.core.models.planar import Planar, Plane
from bearingsim.core.models.ring import Ring
from bearingsim.core.models.rollers import Rollers
from bearingsim.core.models.spatial import Spatial
from bearingsim.core.models.static import Static
from bearingsim.core.parts.bending import Bending, NoSprings, RigidRing, Springs
from bearingsim.core.parts.cage import Centred, FreeCage, KinematicCage, NoDrag, OilDrag, RingGuided
from bearingsim.core.parts.cage_in_space import CageInPlane, CageInSpace
from bearingsim.core.parts.flanges import Flanges, NoFlanges, RollerInRing
from bearingsim.core.parts.mounts import ElasticMount, RigidMount, set_mounted_ring
from bearingsim.core.parts.shaft import (
    ElasticShaft,
    FixedRing,
    RigidShaft,
    TorsionSpring,
    accelerate_inner_ring,
    accelerate_ring_rotation,
    mobility,
)

Found = dict[Any, frozenset[type]]
"""Generics and the types that each is implemented for."""

MODULES = [
    importlib.import_module(module.name)
    for module in pkgutil.walk_packages(bearingsim.core.__path__, "bearingsim.core.")
]
BY_ROLLER = (shared, load_roller, accelerate_shared, accelerate_roller)
ADAPTIVE = (attempt, interpolate, reach, estimate_order, failure_outcome, jump_weight, complete_dense_output)


def ours(types: Any) -> frozenset[type]:
    """Those of the package: tests register types of their own."""
    return frozenset(one for one in types if one.__module__.startswith("bearingsim."))


FOUND: Found = {one: ours(one.types) for one in jit.GENERICS if one.__module__.startswith("bearingsim.")}
STEPPED_EVENLY = FOUND[step].difference(*(FOUND[one] for one in ADAPTIVE))
IN_PLACE_OF: dict[type, type] = {
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
}
"""Types that stand for nothing, and one of the family that each belongs to: some need no implementation at all."""

EXCEPTIONS: list[tuple[tuple[Any, ...], Any, str]] = [
    ((response_groups,), {TracedPath}, "its groups are made with its table, from paths: `defects/traced.py`"),
    (
        (section_of,),
        {Elliptical, EasedDefect, MirroredDefect, ShiftedDefect, MergedDefects, Spall, ScannedDefect},
        "their paths are traced",
    ),
    ((roller_at_defect,), {Impulse}, "it has no pits"),
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
    (ADAPTIVE, STEPPED_EVENLY, "`adaptive.py` does not drive them"),
    ((*ADAPTIVE, step, prepare, stability_ratio), {NoUpdate}, "it is no method, but how none moves the state"),
    ((drift, kick), FOUND[step] - {Verlet, SymplecticEuler}, "their stages are more than a drift and a kick"),
    ((accelerate_inner_ring,), {TorsionSpring}, "a bracket holds the outer ring"),
    ((accelerate_ring_rotation,), {ElasticShaft}, "a shaft carries the inner ring"),
]
"""Generics, the types that they have no implementation for, and why."""

BESIDE = {RollerInRing, Bodies, Monitor, Plane, RingMotion}
"""Tuples that no generic is chosen by, though they stand in one module with types of a family."""


class Anything:
    """A type that nobody has heard of."""


@jit.absent
class Nothing:
    """And one that stands for nothing."""


def excepted(of: Any) -> set[type]:
    return {one for generics, types, _ in EXCEPTIONS if of in generics for one in types}


def served(of: Any, types: frozenset[type]) -> set[type]:
    """Those that need no implementation: all if there is one for any type, else those that stand for nothing."""
    nothing = jit.ABSENT if of.supports(Nothing) else set()
    return {one for one in types if of.supports(Anything) or one in nothing}


def linked(types: frozenset[type]) -> frozenset[type]:
    """With those that stand for nothing in place of them, and the other way round."""
    return types.union(*(pair for pair in IN_PLACE_OF.items() if types.intersection(pair)))


def families(found: Found) -> list[tuple[list[Any], frozenset[type]]]:
    """Generics that share types, and all the types of each such family."""
    merged: list[tuple[list[Any], frozenset[type]]] = []
    for generic, types in ((one, linked(types)) for one, types in found.items()):
        joined = [family for family in merged if family[1] & types]
        merged = [family for family in merged if not family[1] & types]
        members = [generic, *(member for family in joined for member in family[0])]
        merged.append((members, types.union(*(family[1] for family in joined))))
    return merged


def is_tuple(of: Any) -> bool:
    return isinstance(of, type) and issubclass(of, tuple) and hasattr(of, "_fields")


def missing(found: Found) -> list[str]:
    """Generics without an implementation that a type of their family needs; and exceptions that are none."""
    said = []
    for generics, types in families(found):
        for one in generics:
            lacking, left_out = types - found[one] - served(one, types), excepted(one)
            said += [f"{one.__name__} has none for {kind.__name__}" for kind in lacking - left_out]
            said += [f"{one.__name__} needs no exception of {kind.__name__}" for kind in left_out - lacking]
    return said


def lost(found: Found) -> set[type]:
    """Types in no family: tuples beside others that are in one, and types that stand for nothing."""
    known = frozenset().union(*(types for _, types in families(found)))
    homes = {kind.__module__ for kind in known}
    tuples = {kind for module in MODULES for kind in vars(module).values() if is_tuple(kind)}
    beside = {kind for kind in tuples if kind.__module__ in homes}
    return ((beside - BESIDE) | ours(jit.ABSENT)) - known


def complaints(found: Found) -> list[str]:
    """All that is not as it must be, in words."""
    empty = [f"{one.__name__} has no implementation" for one, types in found.items() if not types]
    return empty + missing(found) + [f"no generic is chosen by {kind.__name__}" for kind in lost(found)]


def test_nothing_is_missing() -> None:
    assert complaints(FOUND) == []


def test_any_one_that_is_taken_away_is_missed() -> None:
    """But of generics that say what holds for all other types."""
    pairs = [(one, kind) for one, types in FOUND.items() for kind in types if not one.supports(Anything)]
    unnoticed = [
        (one.__name__, kind.__name__) for one, kind in pairs if not complaints(FOUND | {one: FOUND[one] - {kind}})
    ]
    assert unnoticed == []
    assert len(pairs) > 290


@pytest.mark.parametrize(("one", "kind"), [(defect_response_gradient, TracedPath), (set_mounted_ring, RigidMount)])
def test_a_type_that_is_taken_away_from_one_is_named(one: Any, kind: type) -> None:
    said = complaints(FOUND | {one: FOUND[one] - {kind}})
    assert said == [f"{one.__name__} has none for {kind.__name__}"]


def test_a_new_type_is_wanted_everywhere() -> None:
    class New:
        pass

    said = complaints(FOUND | {normal_force: FOUND[normal_force] | {New}})
    others = (damping_bound, derivatives, stiffness_bound)
    assert sorted(said) == sorted(f"{one.__name__} has none for New" for one in others)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (normal_force, derivatives),
        (mobility, accelerate_ring_rotation),
        (count_crossings, linearise),
        (elastic, as_power),
    ],
)
def test_generics_of_one_family_are_found_together(one: Any, other: Any) -> None:
    (family,) = (generics for generics, _ in families(FOUND) if one in generics)
    assert other in family
    assert defect_response_gradient not in family
