"""Completion of a case: default values that depend on other values, and the slices of a roller."""

import math
from functools import lru_cache
from typing import Any

from bearingsim import catalogue
from bearingsim.config.case_fields import CaseFields
from bearingsim.config.channels import line_load_of
from bearingsim.config.rules import hierarchy
from bearingsim.config.sections import free
from bearingsim.config.sections.contact import Contact
from bearingsim.config.sections.defect import EDGE_RADIUS, Defect, Edge
from bearingsim.config.sections.machine import Rig
from bearingsim.config.sections.ring import MAX_HARMONICS, RingLoad
from bearingsim.config.sections.surfaces import Surfaces


def complete(case: CaseFields) -> None:
    """Fill in all values that depend on others, in place: the model, its defaults, and fields of sections.

    The order matters, because later values depend on the model and the excitation.
    """
    if case.model == catalogue.REFERENCE:
        _fill_reference(case)
    model = catalogue.MODELS[case.model]
    if not model.has_defect_geometry and "excitation" not in case.model_fields_set:
        _fill(case, "excitation", "impulse-train")
    if case.method in (None, catalogue.AUTO):
        _fill(case, "method", None if model.own_method else catalogue.AUTO)
    if "start_angle" not in case.model_fields_set:
        _fill(case, "start_angle", math.pi / case.bearing.rollers)
    _fill(case, "contact", _complete_contact(case))
    _fill(case, "rig", complete_rig(case))
    _fill(case, "defects", tuple(_add_edge(case, _add_roller_number(defect)) for defect in case.defects))
    if case.misalignment is not None and case.misalignment.inner == case.misalignment.outer == 0.0:
        _fill(case, "misalignment", None)
    _fill(case, "surfaces", complete_surfaces(case.surfaces))
    _fill_free_motion(case)
    _fill(case, "record", tuple(name for channel in case.record for name in slice_channels(channel, case)))


def _fill_reference(case: CaseFields) -> None:
    """Fill in the reference model, with a kinematic cage unless the case specifies or records slip."""
    _fill(case, "model", hierarchy.reference_model(case) or catalogue.most_detailed_model())
    if catalogue.MODELS[case.model].slips and not hierarchy.specifies_slip(case):
        _fill(case, "cage", free.Cage(motion="kinematic"))


def complete_surfaces(surfaces: Surfaces | None) -> Surfaces | None:
    """Replace surfaces without deviation by None, and a seed without effect by 0."""
    if surfaces is None:
        return None
    names = ("outer", "inner", "rollers")
    forms = {name: getattr(surfaces, name) for name in names}
    forms = {name: None if form is None or form.is_smooth else form for name, form in forms.items()}
    if not any(forms.values()):
        return None
    simplified = surfaces.model_copy(update=forms)
    return simplified if simplified.is_random else simplified.model_copy(update={"seed": 0})


EXTRA_HARMONICS, HOUSING_HARMONICS = 7, 8
"""Default highest harmonic of a flexible ring: for a sensor on the ring, the excess over the number of rollers,
which resolves the bulge at each roller; for a sensor on the housing, the harmonic itself."""
CARRIER_MASS = 1.0  # kg, default (assumed)


def complete_rig(case: CaseFields) -> Rig:
    """Return the rig with the cross-section, harmonics and load path of a flexible ring filled in."""
    ring, load = case.rig.ring, case.rig.load or RingLoad()
    if ring is None:
        return case.rig
    harmonics = ring.harmonics
    if harmonics == "auto":
        on_ring = case.rig.sensor.on_ring
        harmonics = min(MAX_HARMONICS, case.bearing.rollers + EXTRA_HARMONICS) if on_ring else HOUSING_HARMONICS
    dimensions = {
        name: getattr(ring.section, name) or default for name, default in case.bearing.ring_section.items()
    }
    ring_update = {"harmonics": harmonics, "section": ring.section.model_copy(update=dimensions)}
    load_update = {"mass": load.mass or CARRIER_MASS} if load.has_carrier else {}
    load_update |= {"fit": load.fit or 0.0} if load.by == "housing" else {}
    return case.rig.model_copy(
        update={"ring": ring.model_copy(update=ring_update), "load": load.model_copy(update=load_update)}
    )


def _fill_free_motion(case: CaseFields) -> None:
    """Fill in cage and friction of a model with slip; remove `friction: none` from any other."""
    if not catalogue.MODELS[case.model].slips:
        if isinstance(case.friction, free.Frictionless):
            _fill(case, "friction", None)
        return
    cage = case.cage or free.Cage()
    _fill(case, "cage", cage)
    if case.friction is None:
        _fill(case, "friction", free.Frictionless() if cage.motion == "kinematic" else free.StaticDynamic())


def _add_edge(case: CaseFields, defect: Defect) -> Defect:
    """Return a defect with the default edges of the case's excitation, if it needs edges."""
    if case.excitation != "elastic-edge" or defect.edge is not None:
        return defect
    return defect.model_copy(update={"edge": Edge(radius=EDGE_RADIUS)})


def _add_roller_number(defect: Defect) -> Defect:
    """Return a defect with the default number of its roller, if it is on a roller."""
    if defect.race != "roller" or defect.roller is not None:
        return defect
    return defect.model_copy(update={"roller": 1})


def _complete_contact(case: CaseFields) -> Contact:
    """Return the contact with the default stiffness law of the rolling elements filled in."""
    if case.contact.stiffness is not None:
        return case.contact
    law = "palmgren" if case.bearing.element == "roller" else "point"
    return case.contact.model_copy(update={"stiffness": law})


def _fill(case: CaseFields, name: str, value: object) -> None:
    """Set a field of a frozen case."""
    object.__setattr__(case, name, value)


def axial_extent(defect: Defect) -> tuple[float, float]:
    """Return the positions (m, m) of a defect's ends along the axis, from the roller's centre."""
    return defect.offset - defect.length / 2.0, defect.offset + defect.length / 2.0


def slice_ends(case: CaseFields) -> Any:
    """Return the positions of the ends of a roller's slices, (n + 1,), in m from its centre.

    Raises ValueError for too many slices.
    """
    defects = tuple(map(axial_extent, case.defects))
    return _slice_ends(float(case.bearing.roller_length or 0.0), defects, case.contact.slices)


@lru_cache(maxsize=1 << 12)
def _slice_ends(length: float, defects: tuple[tuple[float, float], ...], count: int) -> Any:
    from bearingsim.core.geometry.slices import slice_edges  # imports numpy

    edges = slice_edges(length, defects, count)
    edges.flags.writeable = False  # shared by many cases
    return edges


def slice_count(case: CaseFields) -> int | None:
    """Count the slices of a roller; None if the model has none, or for too many, which is a conflict."""
    if not catalogue.MODELS[case.model].sliced or case.bearing.roller_length is None:
        return None
    try:
        return len(slice_ends(case)) - 1
    except ValueError:
        return None


def slice_channels(channel: str, case: CaseFields) -> tuple[str, ...]:
    """Return the channels of all slices for a line load along the whole roller, else the channel itself."""
    line_load, count = line_load_of(channel), slice_count(case)
    if line_load is None or count is None:
        return (channel,)
    return tuple(f"{line_load}.{number}" for number in range(1, count + 1))
