"""Material and geometry of the contacting bodies."""

from typing import NamedTuple

from bearingsim.core.defects.pairs import outer_reduced_radius
from bearingsim.core.laws.hertz import effective_modulus, half_width
from benchmarks.edges.half_space import hertz_approach, johnson_datum


class Steel(NamedTuple):
    """Elastic constants. E: Pa; nu: 1."""

    E: float = 207e9
    nu: float = 0.3


class Pair(NamedTuple):
    """Roller in an outer race. Radii in m; the defaults are those of an NF308 without clearance."""

    R_w: float = 0.006
    R_o: float = 0.0385
    steel: Steel = Steel()

    @property
    def R(self) -> float:
        """Relative radius (m) of roller and race."""
        return outer_reduced_radius(self.R_w, self.R_o)

    @property
    def D(self) -> float:
        """Johnson's datum (m) of the displacements."""
        return johnson_datum(self.R_w, self.R_o)

    @property
    def E_star(self) -> float:
        """E/(2 (1 - nu^2)) (Pa)."""
        return effective_modulus(*self.steel)

    def half_width(self, force: float) -> float:
        """Compute Hertz's half width b (m) on the race under ``force`` (N/m)."""
        return half_width(force, 1.0, self.R, *self.steel)

    def approach(self, force: float) -> float:
        """Compute the approach (m) on the race under ``force`` (N/m)."""
        return hertz_approach(force, self.half_width(force), self.E_star, self.D)
