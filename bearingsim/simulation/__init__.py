"""Simulation of a case: choice of method and step, time integration, step check, and features."""

from bearingsim.simulation.record import Record
from bearingsim.simulation.run_setup import SimulationError
from bearingsim.simulation.simulate import simulate, try_out
from bearingsim.simulation.warm_up import warm

__all__ = ["Record", "SimulationError", "simulate", "try_out", "warm"]
