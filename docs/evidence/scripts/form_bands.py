"""Bands of what is seldom measured: form, shaft, ring mass, edges, clearance, bracket, damping, in three scenes.

    python docs/evidence/scripts/form_bands.py --csv docs/data/form_bands.csv
    make figures NAME=form_bands.png

`planar` with a kinematic cage and a slot of 0.8 mm (a bowl for the ball bearing); a shaft of 1e9 N/m and 3 kg. Each
parameter alone, the others at their values: smooth surfaces, ring and bracket of `bvt5`, sharp edges, 2.5 us.
"""

import argparse
from collections.abc import Iterator
from csv import DictWriter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib

from bearingsim.simulation.simulate import simulate
from bearingsim.study import load_study

STUDY = """\
study: bands
bearing: {bearing}
speed: 1800 rpm
load: {load}
model: planar
cage: {{motion: kinematic}}
shaft: {{stiffness: 1e9 N/m, mass: 3 kg}}
defect: {{shape: {shape}, width: 0.8 mm, depth: 50 um}}
duration: 0.5 s
record: []
features: [envelope@BPFO]
uncertainty:
  form: 0.35 um
  shaft: [2e7 N/m, 2e8 N/m]
  ring_mass: [1 kg, 5 kg]
  edge: [20 um, 200 um]
  clearance: [0 um, 3 um]
  bracket: [0.5, 2]
  damping: [0.5 us, 10 us]
"""
SCENES = (
    ("nf308", "150 N", "rectangular, length: 12 mm"),
    ("nu210", "6 kN", "rectangular, length: 11 mm"),
    ("6205", "1 kN", "circular, length: 0.8 mm"),
)
LABELS = {"velocity@BPFO": "line at BPFO", "envelope@BPFO": "line of the squared envelope", "velocity.rms": "RMS, 4 kHz"}
NAMES = {f"{bearing}, {load}": f"{bearing.upper()}, {load}" for bearing, load, _ in SCENES}
UNKNOWNS = {
    "form": "form, 0.35 \u00b5m on both races",
    "clearance": "clearance, 0 to 3 \u00b5m",
    "shaft": "shaft, 2e7 to 2e8 N/m",
    "ring_mass": "ring mass, 1 to 5 kg",
    "edge": "edge radius, 20 to 200 \u00b5m",
    "bracket": "bracket, times 0.5 to 2",
    "damping": "damping, 0.5 to 10 \u00b5s",
}
COLUMNS = ("scene", "unknown", "feature", "base", "lowest", "highest")


def bands(bearing: str, load: str, shape: str) -> Iterator[dict[str, Any]]:
    """Yield the value of each feature of one scene (SI), and its range over each unknown."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "bands.yaml"
        path.write_text(STUDY.format(bearing=bearing, load=load, shape=shape))
        study = load_study(path)
    base = simulate(study.cases()[0]).features
    values: dict[str, list[dict[str, float]]] = {}
    for variation in study.variations():
        values.setdefault(variation.what, []).append(simulate(variation.job.case).features)
    for unknown, varied in values.items():
        for feature in LABELS:
            found = [record[feature] for record in varied]
            scene = f"{bearing}, {load}"
            yield dict(zip(COLUMNS, (scene, unknown, feature, base[feature], min(found), max(found)), strict=True))


def print_table(rows: list[dict[str, Any]]) -> None:
    """Print the changes relative to the value of the smooth bearing."""
    for row in rows:
        low, high = (100.0 * (row[end] / row["base"] - 1.0) for end in ("lowest", "highest"))
        print(row["scene"], row["unknown"], row["feature"], f"{row['base']:.3g}", f"{low:+.0f} to {high:+.0f} %")


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """Draw the range of each feature over each unknown, relative to the smooth bearing, on logarithmic axes."""
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.ticker import FixedLocator, NullLocator

    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    figure, axes = pyplot.subplots(len(scenes), len(LABELS), figsize=(11.0, 7.5), sharex=True, sharey=True)
    for i, scene in enumerate(scenes):
        for j, (feature, label) in enumerate(LABELS.items()):
            axis = axes[i][j]
            for place, unknown in enumerate(UNKNOWNS):
                (row,) = (
                    row
                    for row in rows
                    if (row["scene"], row["unknown"], row["feature"]) == (scene, unknown, feature)
                )
                low, high = (row[end] / row["base"] for end in ("lowest", "highest"))
                ends = min(low, 1.0), max(high, 1.0)
                axis.barh(place, ends[1] - ends[0], left=ends[0], height=0.6, color="C0" if unknown != "form" else "C3")
            axis.axvline(1.0, color="black", linewidth=0.8)
            axis.set_xscale("log")
            axis.xaxis.set_major_locator(FixedLocator([1.0 / 64.0, 1.0 / 16.0, 0.25, 1.0, 4.0]))
            axis.xaxis.set_minor_locator(NullLocator())
            axis.set_xticklabels(["1/64", "1/16", "1/4", "1", "4"])
            axis.grid(axis="x", alpha=0.3)
            axis.set_title(f"{NAMES[scene]}: {label}" if j == 0 else label, fontsize=9)
    axes[0][0].set_yticks(range(len(UNKNOWNS)), list(UNKNOWNS.values()))
    axes[0][0].invert_yaxis()
    for axis in axes.flat:
        axis.tick_params(labelsize=8)
    for axis in axes[-1]:
        axis.set_xlabel("relative to the smooth bearing", fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def main() -> None:
    """Compute the bands, print them, and write them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", type=Path, help="file for the table")
    options = parser.parse_args()
    rows = [row for scene in SCENES for row in bands(*scene)]
    print_table(rows)
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(
                row | {name: f"{row[name]:.6g}" for name in ("base", "lowest", "highest")} for row in rows
            )


if __name__ == "__main__":
    main()
