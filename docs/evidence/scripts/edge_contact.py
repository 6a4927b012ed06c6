"""How far the reduced contact can be trusted at the edge of a pit (docs/edges.md).

    python docs/evidence/scripts/edge_contact.py [--csv FILE] [--png FILE] [--answers]

Elastic contact of a roller over slots by finite elements (they need scikit-fem: `make install-dev`), the reduced
contact and its correction: about 2 CPU minutes. Instead: --answers: what the correction does to the vibration in
`rollers`; --stress: pressure and von Mises stress at an edge.
"""

import argparse
from collections.abc import Iterable
from math import inf
from typing import Any
from unittest import mock

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bearingsim import assemble, simulate
from bearingsim.assemble.rest import largest_load
from bearingsim.config import Case
from bearingsim.core.defects.edge_contact import make_edge_contact
from bearingsim.core.laws.stiffness.power_laws import LINE_CONTACT_EXPONENT
from bearingsim.plots.style import COLOURS, MARKERS, RC
from benchmarks.edges.edge import (
    contact_at_approach,
    contact_stresses,
    contact_under_force,
    corrected_ratio,
    edge_contact_response,
    make_body,
)
from benchmarks.edges.race import Slot, slope_reach
from benchmarks.edges.steel import Pair

PAIR, LENGTH, DEEP = Pair(), 0.012, 50e-6
REFERENCE = 47.0 / LENGTH  # N/m: the largest healthy load at 150 N
LOADS = (5.0, 15.0, 47.0, 150.0, 500.0)  # N on a roller of 12 mm
RADII = (2e-6, 10e-6, 20e-6, 50e-6)
DEPTHS = (1e-6, 5e-6, 20e-6, 50e-6)
WIDTHS = (0.05e-3, 0.1e-3, 0.2e-3, 0.8e-3, 2e-3)
BEHIND = (-3.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0)  # b behind the rim
SOFT_EDGE = 0.65
ANSWERS = ("velocity@BPFO", "velocity.rms", "acceleration.rms", "outer_force.max")


def rows_of(slot: Slot, loads: Iterable[float], places: Iterable[float], cut_out: bool = True) -> list[dict]:
    """One row for each load (N) and place (m behind the rim) where the roller does not reach the floor."""
    body, rows = make_body(PAIR, slot, cut_out=cut_out), []
    for load in loads:
        for s in places:
            if min(s, slot.width - s) < 0.9 * slope_reach(PAIR.R, slot.depth):
                rows.append(row_of(slot, body, load, s) | {"method": "elements" if cut_out else "half-planes"})
    return rows


def row_of(slot: Slot, body: Any, load: float, s: float) -> dict:
    """What the table says of one contact."""
    force = load / LENGTH
    found = contact_under_force(PAIR, slot, body, force, s)
    corrected = corrected_ratio(PAIR, slot, REFERENCE, force, s) if slot.rho > 0.0 else np.nan
    return {
        "width (um)": 1e6 * slot.width,
        "depth (um)": 1e6 * slot.depth,
        "edge radius (um)": 1e6 * slot.rho,
        "load (N)": load,
        "behind the rim (um)": 1e6 * s,
        "half width (um)": 1e6 * PAIR.half_width(force),
        "approach (um)": 1e6 * found.approach,
        "envelope (um)": 1e6 * found.h,
        "approach on the race (um)": 1e6 * found.smooth_approach,
        "approach, elastic over reduced": found.ratio,
        "the same, corrected": corrected,
        "stiffness, elastic over reduced": found.stiffness,
        "largest pressure (GPa)": 1e-9 * found.pressure,
    }


def table() -> pd.DataFrame:
    """All contacts: one edge by depth, edge radius and load; slots by width."""
    rows: list[dict] = []
    for depth in DEPTHS:
        for rho in RADII:
            for load in LOADS:
                behind = np.array(BEHIND) * PAIR.half_width(load / LENGTH)
                rows += rows_of(Slot(inf, depth, rho), (load,), behind)
    b = PAIR.half_width(REFERENCE)
    rows += rows_of(Slot(inf, DEEP, 0.0), (47.0,), np.array(BEHIND) * b, cut_out=False)
    for width in WIDTHS:
        for rho in RADII[1:3]:
            rows += rows_of(Slot(width, DEEP, rho), (47.0,), across(width, b))
    return pd.DataFrame(rows)


def across(width: float, b: float) -> np.ndarray:
    """Places (m behind the left rim) from 2 b before it to the middle, close together next to that."""
    half = width / 2.0
    near = half - np.array([0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5]) * b
    return np.unique(np.concatenate([np.linspace(-2.0 * b, half, 25), near[near > 0.0]]))


# The figure


def draw(found: pd.DataFrame, png: str) -> None:
    """Four panels: one edge, slots, the chart by edge radius, the force at one approach."""
    with plt.rc_context(RC):  # type: ignore[arg-type]
        figure, panels = plt.subplots(2, 2, figsize=(11.0, 8.2), layout="constrained")
        edge_panel(panels[0, 0], found)
        slot_panel(panels[0, 1], found)
        chart_panel(panels[1, 0], found)
        force_panel(panels[1, 1])
        figure.savefig(png, dpi=130)
        plt.close(figure)


def edge_panel(axes: Axes, found: pd.DataFrame) -> None:
    """One edge, 47 N, 50 um deep: approach over the reduced contact's, by edge radius."""
    b = PAIR.half_width(REFERENCE)
    one = found[np.isinf(found["width (um)"]) & (found["load (N)"] == 47.0)]
    places = np.linspace(-3.0, 20.0, 200)
    for k, rho in enumerate(RADII):
        some = one[(one["depth (um)"] == 1e6 * DEEP) & np.isclose(one["edge radius (um)"], 1e6 * rho)]
        x = some["behind the rim (um)"] / some["half width (um)"]
        axes.plot(x, some["approach, elastic over reduced"], MARKERS[k], color=COLOURS[k], ms=5)
        line = [corrected_ratio(PAIR, Slot(inf, DEEP, rho), REFERENCE, REFERENCE, p * b) for p in places]
        axes.plot(places, line, color=COLOURS[k], label=f"edge radius {1e6 * rho:.0f} um")
    sharp = one[one["method"] == "half-planes"]
    x = sharp["behind the rim (um)"] / sharp["half width (um)"]
    axes.plot(x, sharp["approach, elastic over reduced"], "k:", label="sharp, material not cut out")
    axes.axhline(SOFT_EDGE**-0.9, color="0.6", lw=0.8, ls="--")
    axes.set(xlabel="distance behind the rim s / b", ylabel="approach, elastic over reduced")
    axes.set_title("One edge, 50 um deep, 47 N (b = 17.7 um)")
    axes.annotate("soft-edge", (-3.0, SOFT_EDGE**-0.9 + 0.01), color="0.4", fontsize=8.0)
    axes.legend(loc="lower right")


def slot_panel(axes: Axes, found: pd.DataFrame) -> None:
    """Slots, 47 N: the same from rim to middle, by width."""
    b = PAIR.half_width(REFERENCE)
    for k, width in enumerate(WIDTHS[:4]):
        slot = Slot(width, DEEP, 20e-6)
        some = found[np.isclose(found["width (um)"], 1e6 * width) & np.isclose(found["edge radius (um)"], 20.0)]
        x = some["behind the rim (um)"] * 2.0 / some["width (um)"]
        axes.plot(x, some["approach, elastic over reduced"], MARKERS[k], color=COLOURS[k], ms=4)
        places = np.linspace(-2.0 * b, width / 2.0, 400)
        line = [corrected_ratio(PAIR, slot, REFERENCE, REFERENCE, s) for s in places]
        axes.plot(2.0 * places / width, line, color=COLOURS[k], label=f"{1e3 * width:g} mm = {width / b:.1f} b")
    axes.axhline(1.0, color="0.6", lw=0.8)
    axes.set(xlabel="from rim (0) to middle (1)", ylabel="approach, elastic over reduced", xlim=(-0.5, 1.03))
    axes.set_title("Slots, 50 um deep, edge radius 20 um, 47 N")
    axes.legend(title="width", loc="upper left")


def chart_panel(axes: Axes, found: pd.DataFrame) -> None:
    """One edge, 3 b behind the rim, 47 N: the ratio by edge radius and depth."""
    b = PAIR.half_width(REFERENCE)
    one = found[np.isinf(found["width (um)"]) & (found["edge radius (um)"] > 0.0) & (found["load (N)"] == 47.0)]
    one = one[np.isclose(one["behind the rim (um)"], 3.0 * one["half width (um)"])]
    radii = np.geomspace(1.5e-6, 70e-6, 60)
    for k, depth in enumerate(DEPTHS):
        some = one[np.isclose(one["depth (um)"], 1e6 * depth)]
        x = some["edge radius (um)"] / some["half width (um)"]
        axes.plot(x, some["approach, elastic over reduced"], MARKERS[k], color=COLOURS[k], ms=5)
        slots = [Slot(inf, depth, rho) for rho in radii]
        line = [corrected_ratio(PAIR, slot, REFERENCE, REFERENCE, 3.0 * b) for slot in slots]
        axes.plot(radii / b, line, color=COLOURS[k], label=f"{1e6 * depth:.0f} um = {depth / b:.2f} b")
    axes.set(xscale="log", xlabel="edge radius / b", ylabel="approach, elastic over reduced")
    axes.set_title("One edge, 3 b behind the rim, 47 N")
    axes.legend(title="depth of the pit", loc="upper right")


def force_panel(axes: Axes) -> None:
    """A 0.2 mm slot at the approach that gives 47 N on the race: force across it."""
    slot = Slot(0.2e-3, DEEP, 20e-6)
    body, b = make_body(PAIR, slot), PAIR.half_width(REFERENCE)
    full = PAIR.approach(REFERENCE)
    places = np.linspace(-3.0 * b, 4.2 * b, 160)
    elastic = [contact_at_approach(PAIR, slot, body, full, s).force / REFERENCE for s in places[::4]]
    h = np.array([edge_contact_response(PAIR, slot, REFERENCE, s) for s in places])
    rigid = np.maximum(1.0 - np.maximum(places, 0.0) ** 2 / (2.0 * PAIR.R) / full, 0.0) ** (10.0 / 9.0)
    axes.plot(1e6 * places[::4], elastic, "ko", ms=5, label="elastic")
    axes.plot(1e6 * places, rigid, color=COLOURS[0], label="envelope")
    axes.plot(1e6 * places, np.where(places > 0.0, SOFT_EDGE, 1.0) * rigid, color=COLOURS[1], label="soft-edge")
    kept = h[:, 0] * np.maximum(1.0 - h[:, 1] / full, 0.0) ** (10.0 / 9.0)
    axes.plot(1e6 * places, kept, color=COLOURS[2], label="elastic-edge")
    axes.set(xlabel="distance behind the rim s (um)", ylabel="force / force on the race")
    axes.set_title("At one approach (0.168 um), 0.2 mm slot, edge radius 20 um")
    axes.legend(loc="lower left")


def stresses() -> None:
    """Print pressure and stress at one edge, by edge radius, load and place."""
    print("edge radius (um), load (N), s/b: largest pressure, largest von Mises stress (GPa)")
    for rho in RADII:
        for load in LOADS[1::2]:
            b = PAIR.half_width(load / LENGTH)
            places = np.array([-3.0, 0.0, 1.0, 3.0, 10.0]) * b
            for one, mises in contact_stresses(PAIR, Slot(inf, DEEP, rho), load / LENGTH, places):
                print(
                    f"{1e6 * rho:.0f}, {load:g}, {one.s / b:+.0f}: {1e-9 * one.pressure:.2f}, {1e-9 * mises:.2f}"
                )


# What it does to the ring


def case(width: float, excitation: str) -> Case:
    """The NF308 in `rollers` over a full-length slot of ``width`` (m)."""
    slot = {"shape": "rectangular", "length": LENGTH, "width": width, "depth": DEEP}
    scene = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "rollers", "defect": slot}
    scene |= {"contact": {"damping": {"law": "hunt-crossley", "chi": "50 s/m"}}}
    return Case.model_validate(scene | {"duration": 0.5, "settle": 0.1, "excitation": excitation})


def features(width: float, excitation: str, rho: float = 0.0, factor: float = 1.0) -> np.ndarray:
    """``ANSWERS`` with an excitation; with ``rho`` (m) the elastic edge, its reference load times ``factor``."""
    given = case(width, excitation)
    if rho == 0.0:
        return np.array([simulate(given).features[name] for name in ANSWERS])
    load = factor * largest_load(given)
    elastic = make_edge_contact(load, LENGTH, PAIR.R_w, PAIR.R_o, PAIR.E_star, rho, LINE_CONTACT_EXPONENT)
    with mock.patch.object(assemble.defects, "build_excitation", return_value=elastic):
        return np.array([simulate(given).features[name] for name in ANSWERS])


def answers() -> None:
    """Print the features by width, and their change against the envelope (%)."""
    print("width, excitation;", ", ".join(ANSWERS), "(SI); change against the envelope (%)")
    for width in (0.2e-3, 0.8e-3, 2e-3):
        usual = features(width, "envelope")
        others = {"envelope": usual, "soft-edge": features(width, "soft-edge")}
        others |= {f"elastic, {1e6 * rho:.0f} um": features(width, "envelope", rho) for rho in RADII[1:]}
        others |= {f"elastic, 20 um, load x {f:g}": features(width, "envelope", 20e-6, f) for f in (0.3, 3.0)}
        for name, now in others.items():
            shown = " ".join(f"{value:.4g}" for value in now)
            print(f"{1e3 * width:g} mm, {name}: {shown};", (100.0 * (now / usual - 1.0)).round(1), flush=True)


def main() -> None:
    """Make table and figure, or print the answers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--csv", default="docs/data/edge_contact.csv")
    parser.add_argument("--png", default="docs/figures/edge_contact.png")
    parser.add_argument("--answers", action="store_true")
    parser.add_argument("--stress", action="store_true")
    given = parser.parse_args()
    if given.stress:
        return stresses()
    if given.answers:
        return answers()
    found = table()
    found.round(5).to_csv(given.csv, index=False)
    draw(found, given.png)
    return None


if __name__ == "__main__":
    main()
