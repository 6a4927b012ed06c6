"""One case, computed: method and step chosen, the step checked, the motion integrated, features read."""

from bearingsim.simulation.run_setup import SimulationError
from bearingsim.simulation.simulate import Record, simulate, try_out, warm

__all__ = ["Record", "SimulationError", "simulate", "try_out", "warm"]
