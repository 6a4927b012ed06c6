"""A free ring of rectangular section as a curved Timoshenko beam: bending, shear and extension, in closed form.

It shares no code with the package. The mid-line moves by w outward and by v along; the section turns by phi. z
counts outward from the mid-line, r = R + z. Plane sections stay plane. With a prime for d/d theta,

    strain along   = (w + v' + z phi')/(R + z)
    shear          = (w' - (v + z phi))/(R + z) + phi = (w' - v + R phi)/(R + z)

Let w = a cos n theta, v = c sin n theta, phi = p sin n theta. The section has the moments (int: over its
height)

    J0 = int b dz/(R + z) = b ln(outside/inside)
    J1 = int b z dz/(R + z) = A - R J0
    J2 = int b z^2 dz/(R + z) = -R J1

This is Winkler's section: the fibres outside are longer. A straight section has A/R, 0, I/R instead. For n > 0
the ring has the energies (a dot over the unknowns of T)

    V = pi/2 { E [J0 e^2 + 2 n J1 e p + n^2 J2 p^2] + k G J0 g^2 },   e = a + n c,   g = R p - c - n a
    T = pi/2 rho { R A (a^2 + c^2) + 2 I c p + R I p^2 }

since int b (R + z) z dz = I and int b (R + z) z^2 dz = R I.

**Compliance.** A generalised force P acts on a alone: no moment, no force along. With n c = e - a in g,

    (n^2 - 1) a = n R p - e - n g

and e, p, g are free of each other. So Castigliano's theorem gives a/P = h.H^-1 h: h = (-1, n R, -n)/(n^2 - 1),
and H is pi times E [[J0, n J1], [n J1, n^2 J2]] for (e, p) and k G J0 for g. The determinant of the first block
over E^2 is n^2 (J0 J2 - J1^2) = n^2 A J2/R, and

    n^2 J2 + 2 n^2 R J1 + n^2 R^2 J0 = n^2 int b (R + z)^2/(R + z) dz = n^2 R A

so that one term holds all of extension and bending:

    C_n = [ R^2/(E J2) + n^2/(k G J0) ] / (pi (n^2 - 1)^2),  n >= 2          C_0 = 1/(2 pi E J0)

The straight section has R (R^2/I + 1/A)/E + n^2 R/(k G A) in the brackets. For n = 0 only a is left.

**Shear coefficient.** k = 5/6: the shear of a section at rest is a parabola tau = 6 S/(b h^3) (h^2/4 - z^2),
the energy of which is S^2/(2 (5/6) G A), whatever Poisson's ratio. It is that of the energy at rest, which a
compliance is.

**Frequencies** are those of the 3 by 3 problem, the lowest for n >= 2. n = 0 has one, sqrt(K_0/mass).

**One number for each harmonic.** A model that keeps only a takes K_n = 1/C_n, so that it is right at rest, and
M_n = K_n/omega_n^2, so that its frequency is right. M_n is a little more than pi R rho A (1 + 1/n^2), the thin
ring's (0.2 % at n = 2, 6 % at n = 8). It scales with the ring's mass.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

SHEAR = 5 / 6


class Beam(NamedTuple):
    """In m, Pa and kg/m3; ``shear``: the coefficient; ``curved``: Winkler's section or a straight one."""

    inside: float = 0.0385
    outside: float = 0.045
    breadth: float = 0.023
    young: float = 207e9
    poisson: float = 0.3
    density: float = 7850.0
    shear: float = SHEAR
    curved: bool = True

    @property
    def radius(self):
        return 0.5 * (self.inside + self.outside)

    @property
    def area(self):
        return self.breadth * (self.outside - self.inside)

    @property
    def second_moment(self):
        return self.breadth * (self.outside - self.inside) ** 3 / 12

    @property
    def shear_modulus(self):
        return self.young / (2 * (1 + self.poisson))

    @property
    def mass(self):
        return 2 * np.pi * self.radius * self.area * self.density

    @property
    def moments(self):
        """J0 (m), J1 (m2), J2 (m3)."""
        if not self.curved:
            return self.area / self.radius, 0.0, self.second_moment / self.radius
        first = self.breadth * np.log(self.outside / self.inside)
        second = self.area - self.radius * first
        return first, second, -self.radius * second


NF308 = Beam()


def compliance(n, beam=NF308):
    """a_n (m) for a generalised force of 1 N, n = 0 or n >= 2: the closed form."""
    first, _, third = beam.moments
    if n == 0:
        return 1 / (2 * np.pi * beam.young * first)
    extension = 0.0 if beam.curved else beam.radius / (beam.young * beam.area)
    bending = beam.radius**2 / (beam.young * third)
    shear = n * n / (beam.shear * beam.shear_modulus * first)
    return (bending + extension + shear) / (np.pi * (n * n - 1) ** 2)


def matrices(n, beam=NF308):
    """Stiffness and mass (3, 3) of (a, c, p), n >= 1: second derivatives of V and T."""
    first, second, third = beam.moments
    e, p, g = np.array([1, n, 0.0]), np.array([0, 0, 1.0]), np.array([-n, -1, beam.radius])
    bending = (
        first * np.outer(e, e) + n * second * (np.outer(e, p) + np.outer(p, e)) + n * n * third * np.outer(p, p)
    )
    shear = beam.shear * beam.shear_modulus * first * np.outer(g, g)
    translation, rotation = beam.radius * beam.area, beam.second_moment
    mass = np.array([[translation, 0, 0], [0, translation, rotation], [0, rotation, beam.radius * rotation]])
    return np.pi * (beam.young * bending + shear), np.pi * beam.density * mass


def frequencies(n, beam=NF308):
    """The free frequencies of a harmonic in Hz, rising: three for n >= 2, one for n = 0."""
    if n == 0:
        return np.sqrt([1 / (compliance(0, beam) * beam.mass)]) / (2 * np.pi)
    return np.sqrt(eigh(*matrices(n, beam), eigvals_only=True)) / (2 * np.pi)


def modes(harmonics, beam=NF308, mass=None, cap=np.inf):
    """Stiffness (N/m) and mass (kg) of each a_n. ``mass`` (kg): of the whole ring, if it is not the beam's own.

    A harmonic that is faster than ``cap`` (Hz) free gets as much more mass as slows it down to that.
    """
    stiffness = np.array([1 / compliance(n, beam) for n in harmonics])
    lowest = np.array([frequencies(n, beam)[0] for n in harmonics])
    lowest *= np.sqrt(beam.mass / mass) if mass else 1.0
    return stiffness, stiffness / (2 * np.pi * np.minimum(lowest, cap)) ** 2
