"""Scenes of ``solver.py`` and ``solver_planar.py``: SI numbers, and the same case for the package."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from bearingsim.config import Case
from tests.independent.solver_planar import Friction

STATIC_DYNAMIC, TRACTION = Friction(False, 0.3, 0.15, 0.02, 0.1), Friction(True, -0.1, 22.28, 181.46, 0.1)


class Size(NamedTuple):
    """Dimensions of a catalogue bearing; grooves: radii at the outer and the inner race (m), of balls."""

    Z: int
    D_w: float
    L: float
    d_m: float
    outside: float
    breadth: float
    grooves: tuple = ()


SIZES = {
    "nf308": Size(13, 12e-3, 12e-3, 65e-3, 90e-3, 23e-3),
    "nu204": Size(11, 7.5e-3, 7.8e-3, 34e-3, 47e-3, 14e-3),
    "6205": Size(9, 7.94e-3, 0.0, 39.04e-3, 52e-3, 15e-3, (4.208e-3, 4.129e-3)),
}


class Defect(NamedTuple):
    """Defect of a race or roller; angle in degrees, roller from 1, edge: radius of its roundings."""

    shape: str
    length: float
    width: float
    depth: float
    angle: float = 0.0
    race: str = "outer"
    offset: float = 0.0
    roller: int = 0
    edge: float = 0.0


class Wave(NamedTuple):
    """Wave of a surface; phase in degrees, roller from 1 or 0 for all."""

    element: str
    order: int
    amplitude: float
    phase: float = 0.0
    roller: int = 0


@dataclass(frozen=True)
class Scene:
    """Case of `rollers` or `planar`; speeds in rev/min, angles in degrees, else SI.

    stiffness: a name, or coefficient and exponent in N and mm; damping: law and its parameters; other fields of
    planar are those of the case, with numbers instead of quantities.
    """

    bearing: str = "nf308"
    model: str = "rollers"
    speed: float = 1800.0
    load: float = 150.0
    load_across: float = 0.0
    clearance: float = 0.0
    start_angle: float = -3.0
    bracket: tuple = (1e7, 200.0)
    ring_mass: float | None = None
    stiffness: Any = None
    damping: tuple = ("kraemer", 2.5e-6)
    excitation: str = "envelope"
    defects: tuple = ()
    waves: tuple = ()
    diameters: tuple = ()
    friction: Friction = STATIC_DYNAMIC
    guide: str = "centred"
    drag: tuple | None = None  # pairs of a key and its value
    gravity: bool = False
    shaft: tuple = ()  # k, m, c
    unbalance: tuple = ()  # kg m, degrees
    torsion: tuple = ()  # k, c
    ramp: tuple = ()  # rev/min, s
    span: float = 5e-3
    step: float = 1e-7

    size = property(lambda s: SIZES[s.bearing])
    R_w = property(lambda s: s.size.D_w / 2)
    races = property(  # (M1)
        lambda s: (
            (s.size.d_m + s.size.D_w) / 2 + s.clearance / 4,
            (s.size.d_m - s.size.D_w) / 2 - s.clearance / 4,
        )
    )
    reduced = property(
        lambda s: tuple(1 / (1 / s.R_w - sign / R) for sign, R in zip((1, -1), s.races, strict=True))
    )


def case_of(s: Scene) -> Case:
    """The case of a scene."""
    fields: dict[str, Any] = {
        "bearing": s.bearing, "model": s.model, "speed": f"{s.speed} rpm", "clearance": f"{s.clearance} m",
        "load": f"{s.load} N", "load_across": f"{s.load_across} N", "start_angle": f"{s.start_angle} deg",
        "excitation": s.excitation, "step_check": False, "method": "verlet",
        "contact": {"damping": damping_of(s)} | ({"stiffness": stiffness_of(s)} if s.stiffness else {}),
        "rig": {"bracket_stiffness": f"{s.bracket[0]} N/m", "bracket_damping": f"{s.bracket[1]} N s/m"},
        "defects": [defect_of(d) for d in s.defects],
    }  # fmt: skip
    if s.ring_mass:
        fields["rig"]["ring_mass"] = f"{s.ring_mass} kg"
    if s.waves or s.diameters:
        fields["surfaces"] = surfaces_of(s)
    if s.model == "planar":
        planar_fields(s, fields)
    return Case.model_validate(fields)


def stiffness_of(s: Scene) -> Any:
    if isinstance(s.stiffness, str):
        return s.stiffness
    return {"law": "constant", "coefficient": s.stiffness[0], "exponent": s.stiffness[1]}


def damping_of(s: Scene) -> dict[str, Any]:
    law, *values = s.damping
    match law:
        case "kraemer":
            return {"law": law, "beta": f"{values[0]} s"}
        case "hunt-crossley":
            return {"law": law, "chi": f"{values[0]} s/m"}
        case "loss-factor":
            return {"law": law, "loss_factor": f"{100 * values[0]} %", "frequency": f"{values[1]} Hz"}
    return {"law": law} | dict(
        zip(("coefficient", "velocity_exponent", "indentation_exponent"), values, strict=True)
    )


def defect_of(d: Defect) -> dict[str, Any]:
    lengths = {name: f"{getattr(d, name)} m" for name in ("length", "width", "depth", "offset")}
    fields: dict[str, Any] = {"race": d.race, "shape": d.shape, "angle": f"{d.angle} deg"} | lengths
    if d.roller:
        fields["roller"] = d.roller
    return fields | ({"edge": {"radius": f"{d.edge} m"}} if d.edge else {})


def surfaces_of(s: Scene) -> dict[str, Any]:
    surfaces: dict[str, Any] = {}
    for wave in s.waves:
        harmonic = {"order": wave.order, "amplitude": f"{wave.amplitude} m", "phase": f"{wave.phase} deg"}
        harmonic |= {"roller": wave.roller} if wave.roller else {}
        name = "rollers" if wave.element == "roller" else wave.element
        surfaces.setdefault(name, {}).setdefault("harmonics", []).append(harmonic)
    if s.diameters:
        surfaces.setdefault("rollers", {})["diameter"] = [f"{x} m" for x in s.diameters]
    return surfaces


def planar_fields(s: Scene, fields: dict[str, Any]) -> None:
    """Add the fields that only `planar` has."""
    f = s.friction
    fields["friction"] = (
        "traction"
        if f.traction
        else {
            "law": "static-dynamic",
            "static": f.a,
            "dynamic": f.b,
            "static_speed": f"{f.c} m/s",
            "dynamic_speed": f"{f.d} m/s",
        }
    )
    fields["cage"], fields["gravity"] = {"guide": s.guide}, s.gravity
    if s.drag is not None:
        fields["drag"] = {key: f"{x} Pa s" if key == "oil_viscosity" else x for key, x in s.drag}
    if s.shaft:
        k, m, c = s.shaft
        fields["shaft"] = {"stiffness": f"{k} N/m", "mass": f"{m} kg", "damping": f"{c} N s/m"}
    if s.unbalance:
        fields["unbalance"] = {"mass_radius": f"{s.unbalance[0]} kg m", "angle": f"{s.unbalance[1]} deg"}
    if s.torsion:
        k, c = s.torsion
        fields["rig"] |= {"torsion_stiffness": f"{k} N m/rad", "torsion_damping": f"{c} N m s/rad"}
    if s.ramp:
        fields["ramp"] = {"to": f"{s.ramp[0]} rpm", "time": f"{s.ramp[1]} s"}


UM, MM = 1e-6, 1e-3
SLOT = Defect("rectangular", 12 * MM, 0.8 * MM, 50 * UM)
UNEQUAL = tuple(0.2 * UM * (5 * k % 7 - 3) for k in range(13))
SHAFT: dict[str, Any] = {
    "shaft": (2e7, 1.2, 300.0),
    "unbalance": (50e-6, 30.0),
    "torsion": (1e4, 0.3),
    "friction": TRACTION,
}
FORM: dict[str, Any] = {
    "waves": (
        Wave("outer", 13, 0.3 * UM, 20.0), Wave("outer", 150, 0.02 * UM), Wave("inner", 9, 0.2 * UM, 50.0),
        Wave("roller", 2, 0.1 * UM, 10.0), Wave("roller", 7, 0.1 * UM, 100.0, 1),
    ),
    "diameters": UNEQUAL,
}  # fmt: skip
SERIES = {
    "bowl, clearance, load across": Scene(
        load=400.0, load_across=60.0, clearance=8 * UM,
        defects=(Defect("circular", 7 * MM, 1.1 * MM, 12 * UM, offset=1 * MM),),
    ),
    "V of the inner race, nu204, iso16281, loss factor": Scene(
        "nu204", speed=3600.0, load=250.0, stiffness="iso16281", damping=("loss-factor", 0.3, 8000.0),
        bracket=(3e6, 90.0), ring_mass=0.3,
        defects=(Defect("triangular", 5 * MM, 0.6 * MM, 8 * UM, 4.0, "inner", 1.2 * MM),),
    ),
    "slot of a roller meets slot of the race": Scene(
        damping=("kraemer", 4e-6),
        defects=(SLOT, Defect("rectangular", 12 * MM, 0.6 * MM, 30 * UM, 16.0, "roller", roller=1)),
    ),
    "rounded slot, half ellipsoid, form, johnson": Scene(
        stiffness="johnson", load=600.0, **FORM,
        defects=(
            Defect("rectangular", 12 * MM, 0.7 * MM, 30 * UM, edge=20 * UM),
            Defect("elliptical", 4 * MM, 0.7 * MM, 9 * UM, 12.0, offset=1 * MM),
        ),
    ),
    "rounded short slot, form, preload, johnson": Scene(
        stiffness="johnson", load=800.0, clearance=-2 * UM, **FORM,
        defects=(Defect("rectangular", 6 * MM, 0.4 * MM, 30 * UM, edge=50 * UM),),
    ),
    "balls, short slot, slot of the inner race": Scene(
        "6205", speed=1797.0, load=300.0, clearance=5 * UM,
        defects=(
            Defect("rectangular", 0.4 * MM, 0.5 * MM, 30 * UM),
            Defect("rectangular", 5 * MM, 0.5 * MM, 30 * UM, 15.0, "inner"),
        ),
    ),
    "balls, slot of a ball": Scene(
        "6205", speed=1797.0, load=700.0, load_across=-200.0,
        defects=(Defect("rectangular", 5 * MM, 0.5 * MM, 20 * UM, 8.0, "roller", roller=1),),
    ),
    "planar, shaft, unbalance, torsion": Scene(
        model="planar", load=500.0, defects=(Defect("rectangular", 7 * MM, 0.5 * MM, 30 * UM),), **SHAFT,
    ),
    "planar, slot of the inner race and bowl": Scene(
        model="planar", speed=2400.0, load_across=70.0, clearance=4 * UM, **SHAFT,
        defects=(
            Defect("rectangular", 12 * MM, 0.6 * MM, 30 * UM, 4.0, "inner"),
            Defect("circular", 8 * MM, 0.9 * MM, 9 * UM),
        ),
    ),
    "planar, slot of a roller, gravity": Scene(
        model="planar", load=300.0, gravity=True, damping=("kraemer", 5e-6), **SHAFT,
        defects=(Defect("rectangular", 12 * MM, 0.5 * MM, 30 * UM, 10.0, "roller", roller=1),),
    ),
}  # fmt: skip
