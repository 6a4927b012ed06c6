"""How the contacts of the catalogue's bearings are damped by each law, from light to heavy load.

    python docs/evidence/scripts/catalogue_damping.py [--oil 'VG 68'] [--temperature 55]

Rollers or balls under the load that they have where the bearing carries 0.1 to 50 % of C0 (ISO 76; no clearance),
at 600, 1800 and 6000 rpm. Prints c/k (us) at both races: of an oil film at low frequency and at the element's own,
without hysteresis, and of chi = 50 s/m; then how far the film is from the default, 2.5 us. Last: what a roller
of the NF308, free, keeps of its speed, and the largest force, when it hits the race as it does in a 0.8 mm slot.
"""

import argparse
from typing import Any

import numpy as np

from bearingsim.assemble.contacts import build_contact_law
from bearingsim.assemble.scales import approach, damping_over_stiffness
from bearingsim.config import Case
from bearingsim.core.laws.damping.interface import normal_force

BEARINGS = ("nf308", "nu204", "nu205", "nu206", "nu209", "nu210", "6203", "6205", "6309")
SHARES = (0.001, 0.01, 0.05, 0.2, 0.5)
SPEEDS = (600.0, 1800.0, 6000.0)
DEFAULT = 2.5e-6
CLOSING_SPEED = 0.167  # m/s: of a 0.8 mm slot of the outer race, NF308 at 1800 rpm
STEP = 2e-9  # s, of an impact


def heaviest_load(case: Case, share: float) -> float:
    """Load (N) of the most loaded element where the bearing carries a share of its C0."""
    b = case.bearing
    D, d_m, Z, mm = b.roller_diameter, b.pitch_diameter, b.rollers, 1e3
    if b.roller_length is None:
        return 4.37 / Z * share * 13.0 * Z * (D * mm) ** 2
    return 4.08 / Z * share * 44.0 * (1.0 - D / d_m) * Z * (b.roller_length * mm) * (D * mm)


def case_of(bearing: str, speed: float, damping: dict[str, Any]) -> Case:
    """A healthy bearing with a damping law."""
    return Case.model_validate(
        {"bearing": bearing, "speed": speed * np.pi / 30.0, "load": 100.0, "contact": {"damping": damping}}
    )


def times(case: Case, Q: float) -> list[float]:
    """c/k (s) of a contact under ``Q`` (N) at the outer and at the inner race."""
    laws = [build_contact_law(case, on_outer) for on_outer in (True, False)]
    return [damping_over_stiffness(law, approach(law, Q)) for law in laws]


def impact(case: Case, speed: float) -> tuple[float, float]:
    """Speed of a free roller after an impact on the outer race over that before it, and the largest force (N)."""
    law, m = build_contact_law(case, True), case.bearing.element_mass
    delta, v, peak = 1e-15, speed, 0.0
    while delta > 0.0:
        force = float(normal_force(law, delta, v))
        halfway = v - 0.5 * STEP * force / m
        force = float(normal_force(law, delta + 0.5 * STEP * v, halfway))
        delta, v, peak = delta + STEP * halfway, v - STEP * force / m, max(peak, force)
    return -v / speed, peak


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--oil", default="VG 68")
    parser.add_argument("--temperature", type=float, default=55.0, help="C")
    given = parser.parse_args()
    oil = {"law": "film", "oil": given.oil, "temperature": given.temperature + 273.15, "loss_factor": 0.0}
    laws = {"low": oil, "own": oil | {"at": "own"}, "chi": {"law": "hunt-crossley", "chi": 50.0}}
    print("c/k (us) at the outer, inner race")
    print(f"{'':8}{'rpm':>6}{'C0, %':>7}{'Q, N':>9}{'film, low':>16}{'film, own':>16}{'chi = 50 s/m':>16}")
    found = {"low": [], "own": []}
    for bearing in BEARINGS:
        for speed in SPEEDS:
            cases = {name: case_of(bearing, speed, law) for name, law in laws.items()}
            for share in SHARES:
                Q = heaviest_load(cases["chi"], share)
                took = {name: times(case, Q) for name, case in cases.items()}
                shown = "".join(f"{1e6 * a:9.3g},{1e6 * b:6.3g}" for a, b in took.values())
                print(f"{bearing:8}{speed:6.0f}{100.0 * share:7.3g}{Q:9.4g}{shown}")
                for name, over in found.items():
                    over += [(share, speed, bearing, t / DEFAULT) for t in took[name]]
    for name, over in found.items():
        for only in (None, *SHARES):
            of = np.array([ratio for share, _, _, ratio in over if only in (None, share)])
            low, middle, high = np.quantile(of, (0.05, 0.5, 0.95))
            near = np.mean((of > 1.0 / 3.0) & (of < 3.0))
            which = "all loads" if only is None else f"{100.0 * only:g} % of C0"
            print(
                f"film {name}, {which}: over the default {of.min():.3g} .. {of.max():.3g}"
                f" (5, 50, 95 %: {low:.3g}, {middle:.3g}, {high:.3g}); within a factor 3: {100.0 * near:.0f} %"
            )
    dampings: list[dict[str, Any]] = [{"chi": chi} for chi in (0.3, 5.0, 15.0, 50.0)]
    dampings += [{"beta": beta} for beta in (0.5e-6, 2.5e-6, 10e-6, 25e-6)]
    for law in [*dampings, oil | {"loss_factor": 0.015}, oil | {"loss_factor": 0.015, "at": "own"}]:
        kept, peak = impact(case_of("nf308", 1800.0, law), CLOSING_SPEED)
        print(f"a free roller at {CLOSING_SPEED} m/s: keeps {kept:.3f} of its speed, {peak:.4g} N ({law})")


if __name__ == "__main__":
    main()
