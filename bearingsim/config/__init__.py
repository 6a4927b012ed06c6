"""The typed sections of a study: what may be said, checked, in SI.

Text with units comes in (`"0.8 mm"`, from YAML), floats in SI come out; floats from Python are taken as SI.
All sections are frozen and refuse unknown keys. pydantic's ValidationError is raised for what is wrong.
"""

from bearingsim.config.case import Case, Contact, Damping, Defect, General, HuntCrossley, Kraemer
from bearingsim.config.library import library_names
from bearingsim.config.machine import Bearing, Material, Rig
from bearingsim.config.names import CHANNELS, FEATURES, Channel, Feature, dataset_names

__all__ = [
    "CHANNELS",
    "FEATURES",
    "Bearing",
    "Case",
    "Channel",
    "Contact",
    "Damping",
    "Defect",
    "Feature",
    "General",
    "HuntCrossley",
    "Kraemer",
    "Material",
    "Rig",
    "dataset_names",
    "library_names",
]
