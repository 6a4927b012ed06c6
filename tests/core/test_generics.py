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
from bearingsim.core.laws.damping.interface import normal_force, slopes
from bearingsim.core.laws.stiffness.johnson import Johnson, share_with_johnson
from bearingsim.core.laws.stiffness.linear import Linear
from bearingsim.core.laws.stiffness.power_law import PowerLaw
from bearingsim.core.laws.stiffness.series import as_power, share
from bearingsim.core.laws.stiffness.ten_ninths import TenNinths
from bearingsim.core.laws.stiffness.three_halves import ThreeHalves
from bearingsim.core.methods.adaptive import beyond, complete, dead_end, estimate_order
from bearingsim.core.methods.equilibrium import Equilibrium
from bearingsim.core.methods.impulses import Impulses
from bearingsim.core.methods.interface import attempt, interpolate, prepare, step
from bearingsim.core.models.impulse import Impulse
from bearingsim.core.models.interface import accelerations, freedoms, linearise
from bearingsim.core.models.static import Static
from bearingsim.core.parts.flanges import Flanges, NoFlanges, View
from bearingsim.core.parts.mounts import Held, Sprung, hold
from bearingsim.core.parts.shaft import mobility, move_inner_ring, rotate_ring
from bearingsim.core.parts.space_slopes import touch_flanges
from bearingsim.core.pits.closed_forms import section_of
from bearingsim.core.pits.crossings import spot
from bearingsim.core.pits.depth import Circular, Rectangular, Triangular, section
from bearingsim.core.pits.excitations import Traced, bend, groups
from bearingsim.core.pits.jumps import next_cusp
from bearingsim.core.pits.on_roller import standing

Found = dict[Any, frozenset[type]]
"""Generics and the types that each is implemented for."""

MODULES = [
    importlib.import_module(module.name)
    for module in pkgutil.walk_packages(bearingsim.core.__path__, "bearingsim.core.")
]
ADAPTIVE = (attempt, interpolate, estimate_order, dead_end, beyond, complete)


def ours(types: Any) -> frozenset[type]:
    """Those of the package: tests register types of their own."""
    return frozenset(one for one in types if one.__module__.startswith("bearingsim."))


FOUND: Found = {one: ours(one.types) for one in jit.GENERICS if one.__module__.startswith("bearingsim.")}
STEPPED_EVENLY = FOUND[step].difference(*(FOUND[one] for one in ADAPTIVE))

EXCEPTIONS: list[tuple[tuple[Any, ...], Any, str]] = [
    ((groups,), {Traced}, "its groups are made with its table, from paths: `pits/traced.py`"),
    ((standing,), {Impulse}, "it has no pits"),
    ((section_of,), FOUND[section] - {Rectangular, Triangular, Circular}, "traced: no closed form"),
    ((accelerations, freedoms, linearise, next_cusp), {Static, Impulse}, "`Equilibrium`, `Impulses` step them"),
    ((prepare,), {Equilibrium, Impulses}, "they evaluate no accelerations, and start from the state alone"),
    (ADAPTIVE, STEPPED_EVENLY, "`adaptive.py` does not drive them"),
    ((move_inner_ring,), FOUND[rotate_ring], "a bracket holds the outer ring"),
    ((rotate_ring,), FOUND[move_inner_ring], "a shaft carries the inner ring"),
]
"""Generics, the types that they have no implementation for, and why."""

OWN: dict[Any, set[type]] = {
    spot: {Impulse},
    as_power: {Linear, TenNinths, ThreeHalves, PowerLaw},
    share: {Johnson},
    share_with_johnson: {Johnson},
    hold: {Held, Sprung},
    touch_flanges: {Flanges, NoFlanges},
}
"""Implementations that no other tells: of types served without, or that share no other generic with their like."""

BESIDE = {View}
"""Tuples that no generic is chosen by, though they stand in one module with types of a family."""


def excepted(of: Any) -> set[type]:
    return {one for generics, types, _ in EXCEPTIONS if of in generics for one in types}


def families(found: Found) -> list[tuple[list[Any], frozenset[type]]]:
    """Generics that share types, and all the types of each such family."""
    merged: list[tuple[list[Any], frozenset[type]]] = []
    for generic, types in found.items():
        joined = [family for family in merged if family[1] & types]
        merged = [family for family in merged if not family[1] & types]
        members = [generic, *(member for family in joined for member in family[0])]
        merged.append((members, types.union(*(family[1] for family in joined))))
    return merged


def is_tuple(of: Any) -> bool:
    return isinstance(of, type) and issubclass(of, tuple) and hasattr(of, "_fields")


def complaints(found: Found) -> list[str]:
    """What is missing, in words; and exceptions that are none."""
    said = [f"{generic.__name__} has no implementation" for generic, types in found.items() if not types]
    for generics, types in families(found):
        for one in generics:
            missing, left_out = {kind for kind in types - found[one] if not one.fallback(kind)}, excepted(one)
            own, said_so = {kind for kind in found[one] if one.fallback(kind)}, OWN.get(one, set())
            said += [f"{one.__name__} should have its own for {kind.__name__}" for kind in said_so - found[one]]
            said += [f"{one.__name__} needs none of its own for {kind.__name__}" for kind in own - said_so]
            said += [f"{one.__name__} has none for {kind.__name__}" for kind in missing - left_out - said_so]
            said += [f"{one.__name__} needs no exception of {kind.__name__}" for kind in left_out - missing]
    chosen_by = frozenset().union(*found.values())
    homes = {kind.__module__ for kind in chosen_by}
    tuples = {kind for module in MODULES for kind in vars(module).values() if is_tuple(kind)}
    lost = {kind for kind in tuples - chosen_by if kind.__module__ in homes}
    said += [f"no generic has an implementation for {kind.__name__}" for kind in lost - BESIDE - jit.ABSENT]
    return said


def test_nothing_is_missing() -> None:
    assert complaints(FOUND) == []


def test_any_one_that_is_taken_away_is_missed() -> None:
    pairs = [(generic, kind) for generic, types in FOUND.items() for kind in types]
    unnoticed = [
        (generic.__name__, kind.__name__)
        for generic, kind in pairs
        if not complaints(FOUND | {generic: FOUND[generic] - {kind}})
    ]
    assert unnoticed == []
    assert len(pairs) > 300


def test_a_type_that_is_taken_away_from_one_is_named() -> None:
    (said,) = complaints(FOUND | {bend: FOUND[bend] - {Traced}})
    assert said == "bend has none for Traced"


def test_a_new_type_is_wanted_everywhere() -> None:
    class New:
        pass

    said = complaints(FOUND | {normal_force: FOUND[normal_force] | {New}})
    assert sorted(said) == [f"{name} has none for New" for name in ("damping_bound", "slopes", "stiffness_bound")]


@pytest.mark.parametrize(("one", "other"), [(normal_force, slopes), (mobility, rotate_ring), (spot, linearise)])
def test_generics_of_one_family_are_found_together(one: Any, other: Any) -> None:
    (family,) = (generics for generics, _ in families(FOUND) if one in generics)
    assert other in family
    assert bend not in family
