"""Typed and validated sections of a study, in SI.

Text with units, such as `"0.8 mm"` from YAML, is converted to floats in SI; floats from Python are in SI already.
All sections are frozen and reject unknown keys. Invalid input raises pydantic's ValidationError.
"""

from bearingsim.config.case import Case
from bearingsim.config.fields import Section
from bearingsim.config.library import library_names
from bearingsim.config.names import CHANNELS, FEATURES, Channel, Feature, dataset_names
from bearingsim.config.sections.contact import (
    Constant,
    Contact,
    Damping,
    Film,
    General,
    HuntCrossley,
    Kraemer,
    LossFactor,
)
from bearingsim.config.sections.defect import PATH_EXCITATIONS, Defect, Edge
from bearingsim.config.sections.free import (
    Cage,
    CageFriction,
    Drag,
    Friction,
    Frictionless,
    Ramp,
    Shaft,
    StaticDynamic,
    Traction,
    Unbalance,
)
from bearingsim.config.sections.machine import Bearing, Material, Rig

__all__ = [
    "CHANNELS",
    "FEATURES",
    "PATH_EXCITATIONS",
    "Bearing",
    "Cage",
    "CageFriction",
    "Case",
    "Channel",
    "Constant",
    "Contact",
    "Damping",
    "Defect",
    "Drag",
    "Edge",
    "Feature",
    "Film",
    "Friction",
    "Frictionless",
    "General",
    "HuntCrossley",
    "Kraemer",
    "LossFactor",
    "Material",
    "Ramp",
    "Rig",
    "Section",
    "Shaft",
    "StaticDynamic",
    "Traction",
    "Unbalance",
    "dataset_names",
    "library_names",
]
