"""Conflicts between values of a case, each of which is valid on its own."""

from collections.abc import Callable, Iterator
from math import inf
from typing import TYPE_CHECKING, NamedTuple

from bearingsim import catalogue
from bearingsim.config.bands import EXAMPLES, MAX_FREQUENCY, MIN_PERIODS
from bearingsim.config.channels import roller_number, slice_number, without_numbers
from bearingsim.config.fields import Conflict, Path
from bearingsim.config.names import read_band
from bearingsim.config.rules import hierarchy
from bearingsim.config.rules.completion import slice_count
from bearingsim.config.rules.defects import defect_conflicts
from bearingsim.config.rules.flexible_ring import flexible_ring_conflicts
from bearingsim.config.rules.surfaces import surface_conflicts
from bearingsim.config.sections.defect import IMPULSE_EXCITATIONS
from bearingsim.config.sections.free import Frictionless
from bearingsim.config.sections.surfaces import repeats_each_pass
from bearingsim.text.units import show

if TYPE_CHECKING:
    from bearingsim.config.case_fields import CaseFields
    from bearingsim.config.sections.free import Shaft
    from bearingsim.config.sections.machine import Rig


MAX_TILT = 0.02  # rad, largest plausible misalignment
MAX_SAMPLES = 1e9
"""Largest number of samples of a record: 4 GB per channel in single precision, or a day at 10 kHz."""
MAX_HOOP_STRESS = 2.5e9
"""Pa; largest hoop stress rho v^2 of a thin ring with the surface speed v: the tensile strength of hardened
bearing steel, 2.0 to 2.5 GPa. A steel ring reaches it at 560 m/s."""
MOUNT_FIELDS = ("axial_stiffness", "axial_damping", "tilting_stiffness", "tilting_damping")
"""Fields of `rig` and `shaft` that let a ring tilt and move axially."""


def conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield all conflicts within a case."""
    yield from defect_conflicts(case)
    yield from _model_conflicts(case)
    yield from _contact_conflicts(case)
    yield from surface_conflicts(case)
    yield from _free_motion_conflicts(case)
    yield from _spatial_conflicts(case)
    yield from flexible_ring_conflicts(case)
    yield from _record_conflicts(case)
    yield from _band_conflicts(case)
    yield from until_conflicts(case)
    yield from _size_conflicts(case)


# Model


def _model_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    for need in hierarchy.unmet_needs(case):
        hint = _model_hint(case)
        message = f"the {case.model} model cannot do this: {need.reason}"
        yield Conflict(f"model {need.ability}", (*need.paths, ("model",)), message, hint)
    yield from _method_conflicts(case)


def _method_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    paths: tuple[Path, ...] = (("method",), ("model",))
    if catalogue.MODELS[case.model].own_method and case.method is not None:
        message = f"the {case.model} model has no method, got `{case.method}`"
        yield Conflict("method", paths, message, "remove `method`")
    adaptive = [method.name for method in catalogue.METHODS.values() if method.adaptive]
    if case.tolerance != "auto" and case.method not in ("auto", *adaptive):
        subject = f"`{case.method}` has a fixed step" if case.method else f"{case.model} has no method"
        hint = "give a `step`, or an adaptive method: " + ", ".join(adaptive)
        yield Conflict("tolerance", (("tolerance",), *paths), f"{subject}: `tolerance` has no effect", hint)


def _model_hint(case: "CaseFields") -> str:
    """Return advice on the model of a case."""
    model = hierarchy.simplest_model(case)
    return f"the simplest one that can is `model: {model}`" if model else "no model can compute all of this"


# Contact


def _contact_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    law, element = case.contact.elastic_law, case.bearing.element
    if catalogue.LAWS["stiffness"][law].element not in ("", element):
        paths: tuple[Path, ...] = (("contact", "stiffness"), ("bearing",))
        supported, hint = ("rollers", "use `point`") if element == "ball" else ("balls", "use `palmgren`")
        yield Conflict("contact", paths, f"the law `{law}` is for {supported}, not for {element}s", hint)


# Free motion


def _free_motion_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    if case.unbalance is not None and case.shaft is None:
        message = "an unbalance has no effect on a fixed inner ring"
        yield Conflict("shaft", (("unbalance",),), message, "give `shaft: {stiffness: 1e8 N/m, mass: 1 kg}`")
    if case.rig.torsion_damping is not None and case.rig.torsion_stiffness is None:
        paths: tuple[Path, ...] = (("rig", "torsion_damping"), ("rig",))
        yield Conflict("torsion", paths, "the ring does not rotate without `torsion_stiffness`", "give both")
    if case.cage is not None and case.cage.motion == "kinematic":
        yield from _kinematic_cage_conflicts(case)


def _kinematic_cage_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    assert case.cage is not None
    motion: Path = ("cage", "motion")
    if case.friction is not None and not isinstance(case.friction, Frictionless):
        message = (
            "a kinematic cage needs `friction: none`: friction on its rollers damps too much (RMS 11-15 % low)"
        )
        yield Conflict("kinematic", (("friction",), motion), message, "use `friction: none`, or `motion: free`")
    if case.drag is not None:
        message = "drag has no effect on a kinematic cage"
        yield Conflict("kinematic drag", (("drag",), motion), message, "use `drag: none`, or `motion: free`")
    if case.cage.guide != "centred":
        message = f"a kinematic cage stays centred, got `guide: {case.cage.guide}`"
        yield Conflict(
            "kinematic guide", (("cage", "guide"), motion), message, "omit `guide`, or use `motion: free`"
        )


# Motion in space


def _spatial_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    for name, section in (("rig", case.rig), ("shaft", case.shaft)):
        yield from _mount_conflicts(name, section)
    yield from _misalignment_conflicts(case)
    sliced = catalogue.MODELS[case.model].sliced and case.bearing.roller_length is not None
    if sliced and slice_count(case) is None:
        paths: tuple[Path, ...] = (("contact", "slices"), ("defects",))
        message = "the defects cut the roller into more than 64 slices"
        yield Conflict("slices", paths, message, "use fewer `contact.slices` or fewer defects")


def _mount_conflicts(name: str, section: "Rig | Shaft | None") -> Iterator[Conflict]:
    """Yield the conflict of a ring with only one of the two stiffnesses of its mount."""
    if section is None:
        return
    present = [key for key in MOUNT_FIELDS if getattr(section, key) is not None]
    springs = ("axial_stiffness", "tilting_stiffness")
    missing = [key for key in springs if key not in present]
    if present and missing:
        paths: tuple[Path, ...] = ((name, present[0]), (name,))
        keys = " and ".join(f"`{key}`" for key in missing)
        yield Conflict("sprung", paths, f"a ring that tilts also needs {keys}", "give both stiffnesses")


def _misalignment_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    for ring in ("inner", "outer") if case.misalignment else ():
        tilt = getattr(case.misalignment, ring)
        if abs(tilt) > MAX_TILT:
            message = f"a tilt of {show(tilt, 'deg')} is beyond {show(MAX_TILT, 'deg')}"
            yield Conflict("lean", (("misalignment", ring),), message, "is the unit right? Try mrad")


# Record, bands, sizes, times


def _record_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    for index, name in enumerate(case.record):
        path: Path = ("record", index)
        number = roller_number(name)
        if number is not None and number > case.bearing.rollers:
            message = f"there is no roller {number}: the bearing has {case.bearing.rollers}"
            yield Conflict("channel", (path, ("bearing", "rollers")), message, "numbers start at 1")
        yield from _slice_conflicts(path, name, case)
        zero_reason = _zero_reason(name, case) if catalogue.MODELS[case.model].slips else None
        if zero_reason:
            yield Conflict("still", (path,), f"`{name}` stays zero: {zero_reason[0]}", zero_reason[1])


def _band_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflicts of `features` with the record, the models and `until`."""
    for index, name in enumerate(case.features):
        path: Path = ("features", index)
        feature = read_band(name)
        if feature is None and case.until is None:
            message = f"`{name}` is computed for every case"
            yield Conflict("feature", (path,), message, f"name features of bands, such as {EXAMPLES}")
        if feature is None or feature.band is None:
            continue
        low, high = feature.band
        if not low < high:
            yield Conflict("band", (path,), f"`{name}`: the band is empty", "give the lower frequency first")
        if high > MAX_FREQUENCY:
            message = f"`{name}`: the models are not valid above {show(MAX_FREQUENCY, 'kHz')}"
            yield Conflict("band", (path,), message, "use a lower upper limit")
        resolution = min(low or inf, high - low)
        if 0.0 < resolution < MIN_PERIODS / case.duration:
            min_duration = show(MIN_PERIODS / resolution, "s")
            message = f"`{name}`: a record of {show(case.duration, 's')} does not resolve {resolution:g} Hz"
            yield Conflict("band", (path, ("duration",)), message, f"use a `duration` of {min_duration} or more")


def _slice_conflicts(path: Path, name: str, case: "CaseFields") -> Iterator[Conflict]:
    number = slice_number(name)
    count = slice_count(case)
    if number is not None and count is not None and number > count:
        message = f"there is no slice {number}: the roller has {count}"
        yield Conflict("slice", (path, ("contact", "slices")), message, f"`{name.rpartition('.')[0]}` records all")


def _zero_reason(name: str, case: "CaseFields") -> tuple[str, str] | None:
    """Return the reason why a channel is always zero in this case, and a remedy; None if it is not."""
    if name == "ring.rotation" and case.rig.torsion_stiffness is None:
        return "the bracket fixes the rotation of the ring", "give `rig.torsion_stiffness`"
    if name == "inner.displacement" and case.shaft is None:
        return "the inner ring's centre is fixed", "give `shaft`"
    kinematic = case.cage is not None and case.cage.motion == "kinematic"
    if kinematic and without_numbers(name) in hierarchy.KINEMATIC_CHANNELS:
        return "the cage is kinematic", "use `motion: free`"
    if name in ("ring.axial", "ring.lean") and case.rig.tilting_stiffness is None:
        return "the bracket fixes the ring axially", "give `rig.axial_stiffness` and `rig.tilting_stiffness`"
    if name in ("inner.axial", "inner.lean") and (case.shaft is None or case.shaft.tilting_stiffness is None):
        return "the shaft fixes the ring axially", "give `shaft` with `axial_stiffness` and `tilting_stiffness`"
    if without_numbers(name) == "roller.flange_force" and case.bearing.flanges is None:
        return "the bearing has no flanges", "give `bearing.flanges`"
    if name == "cage.position" and (case.cage is None or case.cage.guide == "centred"):
        return "the cage is centred", "give `cage.guide`"
    return None


def _size_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    if not -0.01 <= case.clearance / case.bearing.roller_diameter <= 0.05:
        clearance = show(case.clearance, "um")
        message = f"a clearance of {clearance} is beyond -1 % to 5 % of the roller diameter"
        yield Conflict("clearance", (("clearance",), ("bearing",)), message, "is the unit right?")
    if case.ramp is not None and getattr(case.contact.damping, "of_one_speed", False):
        message = f"the damping law `{getattr(case.contact.damping, 'law', '')}` is valid for one speed only"
        yield Conflict("film", (("ramp",), ("contact", "damping")), message, "use another law, or omit `ramp`")
    yield from _burst_conflicts(case)
    if case.duration * case.sampling > MAX_SAMPLES:
        message = f"{case.duration * case.sampling:.2g} samples: a record has at most {MAX_SAMPLES:.0e}"
        sample_paths: tuple[Path, ...] = (("duration",), ("sampling",))
        yield Conflict("samples", sample_paths, message, "use a shorter `duration`, or a lower `sampling`")
    ball_pass = 1.0 / case.bearing.ball_pass_frequency(case.speed)
    if case.duration < ball_pass:
        duration, limit = show(case.duration, "ms"), show(ball_pass, "ms")
        duration_paths: tuple[Path, ...] = (("duration",), ("speed",), ("bearing",))
        message = f"{duration} is shorter than one ball pass of {limit}"
        yield Conflict("duration", duration_paths, message, "are the units of `duration` and `speed` right?")
    if (
        case.excitation in IMPULSE_EXCITATIONS
        and not catalogue.MODELS[case.model].has_defect_geometry
        and not case.defects
    ):
        paths: tuple[Path, ...] = (("model",), ("excitation",))
        yield Conflict("silent", paths, "a bearing without a defect has no impulses", "give a `defect`")


def _burst_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of a speed at which the inner ring bursts."""
    speed = case.speed if case.ramp is None else max(case.speed, case.ramp.to)
    surface_speed = speed * (case.bearing.pitch_diameter - case.bearing.roller_diameter) / 2.0
    stress = case.bearing.material.density * surface_speed**2
    if stress > MAX_HOOP_STRESS:
        path: Path = ("speed",) if case.ramp is None or case.speed >= case.ramp.to else ("ramp", "to")
        message = (
            f"at {show(speed, 'rpm')} the inner race moves at {surface_speed:.3g} m/s: its hoop stress rho v^2,"
            f" {stress:.2g} Pa, bursts the ring (over {MAX_HOOP_STRESS:.2g} Pa)"
        )
        yield Conflict("bursts", (path, ("bearing",)), message, "is the unit right?")


class PassCondition(NamedTuple):
    """Condition for identical ball passes: a check of the case, and the reason why passes differ if it fails."""

    is_met: Callable[["CaseFields"], bool]
    reason: str


PASS_CONDITIONS: dict[str, PassCondition] = {
    "ramp": PassCondition(lambda case: case.ramp is None, "the speed changes"),
    "unbalance": PassCondition(lambda case: case.unbalance is None, "an unbalance rotates with the shaft"),
    "defects": PassCondition(lambda case: all(d.race == "outer" for d in case.defects), "a defect rotates"),
    "surfaces": PassCondition(
        lambda case: repeats_each_pass(case.surfaces), "the surfaces of inner race or rollers rotate"
    ),
    "excitation": PassCondition(lambda case: case.excitation != "random-impulses", "impulses are random"),
    "model": PassCondition(
        lambda case: catalogue.MODELS[case.model].repeats, "the model is not declared as periodic"
    ),
    "cage": PassCondition(lambda case: case.cage is None or case.cage.motion == "kinematic", "the cage is free"),
}
"""Conditions for identical ball passes, by field; ``simulation/repetition.py`` adds those of the method."""

REVOLUTION_CONDITIONS = ("defects", "cage")
"""Fields whose conditions `until` does not need, because it compares revolutions of the defect or the cage."""


def until_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflicts of `until`."""
    if case.until is None:
        return
    if case.record:
        message = "`until` ends the record early, so no series can be stored"
        yield Conflict("until", (("until",), ("record",)), message, "use `record: []`, or omit `until`")
    if not case.antialias:
        message = "`until` needs the low-passed signal"
        yield Conflict("until", (("until",), ("antialias",)), message, "omit `antialias: false`")
    if case.step_check == "strict":
        message = "`step_check: strict` checks the whole record, which `until` may shorten"
        yield Conflict("until", (("until",), ("step_check",)), message, "keep one of them")
    for name, condition in PASS_CONDITIONS.items():
        if name not in REVOLUTION_CONDITIONS and not condition.is_met(case):
            message = f"`until` compares revolutions, which differ: {condition.reason}"
            yield Conflict("until", (("until",), (name,)), message, "remove `until`")
