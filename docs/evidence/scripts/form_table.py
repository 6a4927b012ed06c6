"""Effect of random waviness on the spectral lines of an NF308: healthy, and with a slot in the outer race.

    python docs/evidence/scripts/form_table.py > form_table.txt

`rollers`, 1800 rpm, Kraemer damping 2.5 us, 1 s at 10.24 kHz. Both races have A n^-1.3 in orders 2 to 200, eight
seeds; over the angle three seeds, and rollers with a scatter of 0.5 um. Envelope: magnitude of the analytic signal
of 1 to 4 kHz.
Amplitudes in um/s, 0-peak.
"""

import numpy as np
from scipy.signal import hilbert

from bearingsim.config import Case
from bearingsim.simulation.simulate import simulate

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
BPFO = 159.0  # Hz
SEEDS, ANGLE_SEEDS = range(1, 9), range(1, 4)


def quantities(load: str, defect: dict | None, amplitude: str | None, seed: int, scatter: bool = False) -> dict:
    """Return line at BPFO (complex), envelope line and RMS of a case, in um/s."""
    spectrum = {"spectrum": {"amplitude": amplitude}}
    surfaces: dict = {"outer": spectrum, "inner": spectrum, "seed": seed} if amplitude else {}
    if scatter:
        surfaces["rollers"] = {"diameter": {"scatter": "0.5 um"}}
    fields: dict = {"bearing": "nf308", "speed": "1800 rpm", "load": load, "surfaces": surfaces, "settle": "0.1 s"}
    fields |= {"record": ["sensor.velocity"], "step_check": False} | ({"defect": defect} if defect else {})
    record = simulate(Case.model_validate(fields))
    velocity = 1e6 * np.asarray(record.series["sensor.velocity"], float)
    frequencies, lines = np.fft.rfftfreq(len(velocity), 1.0 / 10240.0), np.fft.rfft(velocity)
    band = np.fft.irfft(np.where((frequencies > 1e3) & (frequencies < 4e3), lines, 0.0), len(velocity))
    time = np.arange(len(velocity)) / 10240.0
    envelope = 2.0 * np.mean(np.abs(hilbert(band)) * np.exp(-2j * np.pi * BPFO * time))
    A, phase = record.features["velocity@BPFO"], record.features["velocity@BPFO.phase"]
    return {
        "line": 1e6 * A * np.exp(1j * phase),
        "envelope": abs(envelope),
        "rms": 1e6 * record.features["velocity.rms"],
    }


def span(values: list[float]) -> str:
    """Format the smallest and largest of some values."""
    low, high = min(values), max(values)
    return f"{low:.3g}" if high - low < 1e-3 * high else f"{low:.3g} to {high:.3g}"


def table(load: str) -> None:
    """Print the table of one load."""
    print(f"\n{load}: quantity, ideal, 0.2 um, 0.6 um (amplitude A of order 1)")
    runs = {}
    for amplitude, seeds in ((None, (0,)), ("0.2 um", SEEDS), ("0.6 um", SEEDS)):
        runs[amplitude] = [
            (quantities(load, None, amplitude, seed), quantities(load, SLOT, amplitude, seed)) for seed in seeds
        ]
    rows = {
        "BPFO, healthy": lambda healthy, slot: abs(healthy["line"]),
        "BPFO with slot": lambda healthy, slot: abs(slot["line"]),
        "BPFO, change from healthy": lambda healthy, slot: abs(slot["line"] - healthy["line"]),
        "envelope line, healthy": lambda healthy, slot: healthy["envelope"],
        "envelope line with slot": lambda healthy, slot: slot["envelope"],
        "healthy RMS": lambda healthy, slot: healthy["rms"],
        "RMS with slot": lambda healthy, slot: slot["rms"],
    }
    for name, value in rows.items():
        print(name, *(span([value(*pair) for pair in pairs]) for pairs in runs.values()), sep=" | ")


def angles() -> None:
    """Print amplitude at BPFO, its change from healthy and the envelope's over the angle of the slot."""
    print("\n150 N, slot at 0, 15, 30, 45, 60 deg: BPFO; change from healthy; envelope at BPFO")
    formed = ((f"A 0.2 um, seed {n}", "0.2 um", n) for n in ANGLE_SEEDS)
    for name, amplitude, seed in (("ideal", None, 0), *formed):
        healthy = quantities("150 N", None, amplitude, seed, scatter=amplitude is not None)
        rows = [
            quantities("150 N", SLOT | {"angle": f"{angle} deg"}, amplitude, seed, scatter=amplitude is not None)
            for angle in (0, 15, 30, 45, 60)
        ]
        texts = (
            ", ".join(f"{value:.2g}" for value in values)
            for values in (
                [abs(row["line"]) for row in rows],
                [abs(row["line"] - healthy["line"]) for row in rows],
                [row["envelope"] for row in rows],
            )
        )
        print(name, *texts, sep=" | ")


if __name__ == "__main__":
    table("150 N")
    table("4 kN")
    angles()
