"""Diagnosis of a bearing from a measured signal."""

from bearingsim.diagnosis.detection import NONE, RHYTHM
from bearingsim.diagnosis.kinematics import RACES, Lines
from bearingsim.diagnosis.verdict import EITHER, Diagnosis, Finding, diagnose

__all__ = ["EITHER", "NONE", "RACES", "RHYTHM", "Diagnosis", "Finding", "Lines", "diagnose"]
