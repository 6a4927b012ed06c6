"""Diagnosis of a bearing from a measured signal."""

from bearingsim.diagnosis.detection import NONE, RHYTHM
from bearingsim.diagnosis.kinematics import ELEMENTS, Lines
from bearingsim.diagnosis.verdict import EITHER, Diagnosis, Finding, diagnose

__all__ = ["EITHER", "ELEMENTS", "NONE", "RHYTHM", "Diagnosis", "Finding", "Lines", "diagnose"]
