"""Simulation of a case: choice of method and step, time integration, step check, and features."""

from bearingsim.simulation.record import Record
from bearingsim.simulation.run_setup import SimulationError
from bearingsim.simulation.simulate import run_trial, simulate
from bearingsim.simulation.warm_up import compile_solvers

__all__ = ["Record", "SimulationError", "compile_solvers", "run_trial", "simulate"]
