"""Bands of what is seldom measured: form, shaft, ring mass, edges, clearance, bracket, damping, in three scenes.

    python docs/evidence/scripts/form_bands.py > form_bands.txt

`planar` with a kinematic cage and a slot of 0.8 mm; a shaft of 1e9 N/m and 3 kg. Each parameter alone.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

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
    ("6205", "500 N", "circular, length: 0.8 mm"),
)


def bands(bearing: str, load: str, shape: str) -> None:
    """Print the value and the band of line and RMS of one scene (um/s)."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "bands.yaml"
        path.write_text(STUDY.format(bearing=bearing, load=load, shape=shape))
        study = load_study(path)
    features = ("velocity@BPFO", "velocity.rms")
    base = simulate(study.cases()[0]).features
    print(f"\n{bearing}, {load}:", *(f"{name} {1e6 * base[name]:.3g}" for name in features))
    values: dict[str, list[dict[str, float]]] = {}
    for variation in study.variations():
        values.setdefault(variation.what, []).append(simulate(variation.job.case).features)
    for what, varied in values.items():
        texts = []
        for name in features:
            ratios = [record[name] / base[name] - 1.0 for record in varied]
            texts.append(f"{100.0 * min(ratios):+.0f} to {100.0 * max(ratios):+.0f} %")
        print(what, *texts, sep=" | ")


if __name__ == "__main__":
    for scene in SCENES:
        bands(*scene)
