"""The closed damping of an oil film (core/laws/oil_film.py) against solutions of 60 random contacts.

    python docs/evidence/scripts/film_damping.py [--csv FILE] [--figure FILE]

Rollers of 6 to 20 mm on inner and outer races in turn, 0.05 to 32 % of the load that makes 4 GPa, 300 to 6300
rpm, 8 to 80 mPa s, 16 to 23 1/GPa, seeded. Each is solved at rest and under oscillations, slow and at the roller's
own frequency between both races, by tests/independent/ehl.py. Palmgren's stiffness. About 2 CPU minutes.
"""

import argparse
import csv
import sys
from collections.abc import Iterator
from math import exp, log, pi, sqrt
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

import numpy as np

from bearingsim.core.laws.hertz import effective_modulus
from bearingsim.core.laws.oil_film import (
    LubricatedLine,
    entrainment_speed,
    film_damping,
    film_thickness,
    half_widths,
    inlet_squeeze,
    moes_numbers,
    transition_parameter,
)
from bearingsim.core.laws.oil_viscosity import iso_viscosity
from tests.independent.ehl import Contact, at_rest, light_contact, stiffness

CASES, SEED, CELLS = 60, 20, 200
STEEL, DENSITY, STATIC_PRESSURE = effective_modulus(207e9, 0.3), 7850.0, 4.0e9
FACTOR = 1.25  # that counts as met
COLUMNS = (
    "race", "diameter_mm", "length_mm", "share_of_C0", "load_N", "rpm", "viscosity_mPas", "alpha_per_GPa",
    "u_m_s", "M", "L", "z", "pressure_GPa", "h_solved_um", "h_moes_um", "least_solved_um", "least_moes_um",
    "K_over_k", "c_solved", "c_closed", "ratio", "hard_min_ratio", "c_over_k_us", "own_Hz", "omega_T",
    "c_own_solved", "c_own_closed",
)  # fmt: skip


class Drawn(NamedTuple):
    """A roller's contact: ``share`` of the load that makes 4 GPa, ``D`` (m) its diameter."""

    race: str
    D: float
    share: float
    rpm: float
    Q: float
    line: LubricatedLine

    @property
    def k(self) -> float:
        """Palmgren's stiffness, N/m: delta = 3.84e-5 Q^0.9/L^0.8 mm."""
        return float(1e3 * self.Q**0.1 * (self.line.L * 1e3) ** 0.8 / (0.9 * 3.84e-5))

    @property
    def own(self) -> float:
        """Frequency of the roller on both contacts, rad/s."""
        return sqrt(2.0 * self.k / (DENSITY * pi * self.D**2 / 4.0 * self.line.L))


def relative_radius(race: str, D: float, D_m: float) -> float:
    return 1.0 / (2.0 / D + 2.0 / (D_m - D)) if race == "inner" else 1.0 / (2.0 / D - 2.0 / (D_m + D))


def contact(
    race: str, D: float, L: float, D_m: float, share: float, rpm: float, eta: float, alpha: float
) -> Drawn:
    R = relative_radius(race, D, D_m)
    u = entrainment_speed(rpm * pi / 30.0, D_m, D)
    return Drawn(race, D, share, rpm, share * STATIC_PRESSURE**2 * pi * R / STEEL * L,
                 LubricatedLine(L, R, STEEL, eta, alpha, u))  # fmt: skip


def draw() -> Iterator[Drawn]:
    rng = np.random.default_rng(SEED)
    for number in range(CASES):
        D = float(rng.uniform(6e-3, 20e-3))
        L, D_m = D * float(rng.uniform(0.8, 1.4)), D * float(rng.uniform(3.0, 6.0))
        share, rpm = exp(rng.uniform(log(5e-4), log(0.32))), float(rng.uniform(300.0, 6300.0))
        eta, alpha = exp(rng.uniform(log(8e-3), log(80e-3))), float(rng.uniform(16e-9, 23e-9))
        yield contact(("inner", "outer")[number % 2], D, L, D_m, share, rpm, eta, alpha)


def measure(case: Drawn) -> dict[str, Any]:
    Q, k, line = case.Q, case.k, case.line
    film = at_rest(Contact(Q, *line), CELLS, growth=1.0 + 4.0 / CELLS)
    T = 2.0 * float(half_widths(Q, line)) / line.u
    omega = np.array([1e-3 / T, case.own])
    K = stiffness(film, k, omega)
    slow, fast = K.imag / omega
    closed, (M, L), thickness = film_damping(Q, k, line), moes_numbers(Q, line), film_thickness(Q, line)
    b = half_widths(Q, line)
    A, B = inlet_squeeze(thickness.minimum, line), 0.69 * thickness.central / line.u * k * k * b / (2.0 * Q)
    row = (
        case.race, case.D * 1e3, line.L * 1e3, case.share, Q, case.rpm, line.eta * 1e3, line.alpha * 1e9,
        line.u, M, L, transition_parameter(Q, line), film.contact.hertz / 1e9, film.flow * 1e6, thickness.central * 1e6,
        film.thinnest * 1e6, thickness.minimum * 1e6, K[0].real / k, slow, closed, closed / slow,
        min(A, B) / slow, slow / k * 1e6, case.own / (2.0 * pi), case.own * T, fast,
        film_damping(Q, k, line, case.own),
    )  # fmt: skip
    return dict(zip(COLUMNS, row, strict=True))


def met(ratios: np.ndarray) -> int:
    return int(np.sum(np.abs(np.log(ratios)) < log(FACTOR)))


def spread(values: np.ndarray) -> str:
    return ", ".join(f"{v:.3g}" for v in np.percentile(values, (5, 50, 95)))


def report(rows: list[dict[str, Any]]) -> None:
    def of(column: str) -> np.ndarray:
        return np.array([row[column] for row in rows])

    print(f"c of slow oscillations, closed over solved: {met(of('ratio'))} of {len(rows)} within {FACTOR}")
    print(f"  5, 50, 95 %: {spread(of('ratio'))}; hard minimum of A and B: {met(of('hard_min_ratio'))} within,",
          spread(of("hard_min_ratio")))  # fmt: skip
    for row in sorted(rows, key=lambda r: -abs(log(r["ratio"]))):
        if abs(log(row["ratio"])) > log(FACTOR):
            print("  outside: " + ", ".join(f"{c} {row[c]:.3g}" for c in ("ratio", "M", "L", "z", "c_over_k_us")))
    for name, low, high in (("z < 0.8", 0.0, 0.8), ("0.8 to 1.8", 0.8, 1.8), ("z > 1.8", 1.8, 1e9)):
        chosen = (of("z") > low) & (of("z") <= high)
        print(f"  {name}: {met(of('ratio')[chosen])} of {chosen.sum()}, {spread(of('ratio')[chosen])}")
    print("c/k, us: 5, 50, 95 %:", spread(of("c_over_k_us")))
    print("film over Moes', central:", spread(of("h_solved_um") / of("h_moes_um")),
          "least:", spread(of("least_solved_um") / of("least_moes_um")))  # fmt: skip
    own, closed = of("c_own_solved"), of("c_own_closed")
    print(
        f"at the roller's own frequency {int(np.sum(own <= 0))} solutions have no positive damping; of the others"
    )
    ratio = closed[own > 0] / own[own > 0]
    print(f"  closed over solved {spread(ratio)}; {np.mean(np.abs(np.log(ratio)) < log(3)):.0%} within a factor 3")


def product() -> None:
    """c/k of the closed form on a 12 x 12 mm roller at 65 mm pitch: speeds, viscosities and loads in turn."""
    values, grows = [], []
    for race in ("inner", "outer"):
        for rpm in (300.0, 600.0, 1800.0, 6000.0):
            for eta in (0.010, 0.030, 0.060):
                shares = np.geomspace(1e-4, 0.5, 60)
                cases = [contact(race, 0.012, 0.012, 0.065, s, rpm, eta, 20e-9) for s in shares]
                us = np.array([film_damping(c.Q, c.k, c.line) / c.k * 1e6 for c in cases])
                values.append(us)
                high = np.array([float(film_damping(c.Q, c.k, c.line)) for c in cases])[shares >= 0.1]
                grows.append(high[-1] / high[0])
    every = np.array(values)
    print(f"NF308, 1e-4 to 0.5 of C0, 300-6000 rpm, 10-60 mPa s: c/k {every.min():.3g} to {every.max():.3g} us")
    few = shares[(every < 0.1).any(axis=0)]
    print(f"  under 0.1 us at shares of C0 from {few.min():.2g} to {few.max():.2g}, {np.mean(every < 0.1):.1%}")
    print(f"  c at 50 % over c at 10 % of C0: {min(grows):.3g} to {max(grows):.3g}")
    print("  viscosity of VG 68 at 40, 60, 80 C:", [round(iso_viscosity(68, t), 4) for t in (40.0, 60.0, 80.0)])


def draw_figure(rows: list[dict[str, Any]], path: str) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
    z, solution, closed = (np.array([row[c] for row in rows]) for c in ("z", "c_solved", "c_closed"))
    left.axhspan(1 / FACTOR, FACTOR, color="0.9", label="factor 1.25")
    left.loglog(z, closed / solution, "o", ms=4, label="60 random contacts")
    left.set(xlabel="z = M (L + 20)/21.3", ylabel="c, closed form over solution")
    left.legend(frameon=False)
    for eta, colour in ((0.010, "C0"), (0.030, "C1"), (0.060, "C2")):
        loads = np.geomspace(2e-5, 0.5, 200)
        cases = [contact("inner", 0.012, 0.012, 0.065, s, 1800.0, eta, 20e-9) for s in loads]
        Q = np.array([c.Q for c in cases])
        right.loglog(Q, [film_damping(c.Q, c.k, c.line) for c in cases], colour, label=f"{eta * 1e3:.0f} mPa s")
        dots = [c for c in cases[5::12] if c.Q > 1.1 * light_contact(Contact(c.Q, *c.line)).Q]
        solved = [stiffness(at_rest(Contact(c.Q, *c.line)), c.k, 1.0)[0].imag for c in dots]
        right.loglog([c.Q for c in dots], solved, "o", color=colour, ms=4)
    right.set(xlabel="load of the contact, N", ylabel="damping c, N s/m", ylim=(10, 1e4))
    right.set_title("12 mm roller, 1800 rpm; dots: solutions", fontsize=9)
    right.legend(frameon=False)
    figure.savefig(path, dpi=130)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv")
    parser.add_argument("--figure")
    arguments = parser.parse_args()
    rows = [measure(case) for case in draw()]
    report(rows)
    product()
    if arguments.csv:
        with open(arguments.csv, "w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows({c: v if isinstance(v, str) else f"{v:.5g}" for c, v in row.items()} for row in rows)
    if arguments.figure:
        draw_figure(rows, arguments.figure)


if __name__ == "__main__":
    main()
