"""Files of trials in a results folder; ``trials/<unit>.json`` contains the trials of a unit of work."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bearingsim.simulation.trial import Trial
from bearingsim.store import layouts, own_files
from bearingsim.store.layouts import check
from bearingsim.store.regular import Unreadable
from bearingsim.store.sealed import UNREADABLE, read_json, write_json

TRIALS = "trials"  # name of the folder, and key in a file


def write_trials(root: Path, unit: str, trials: Mapping[str, Trial | None]) -> None:
    """Write the trials of a unit of work. trials: by id, None for a failed trial."""
    entries = {name: None if trial is None else _to_json(trial) for name, trial in trials.items()}
    write_json(root / TRIALS / f"{unit}.json", {TRIALS: entries}, indent=None)


def read_trials(root: Path, features: Collection[str] = ()) -> dict[str, Trial | None]:
    """Read the trials of a results folder that contain all ``features``, by id; None for a failed trial.

    Unreadable files and trials without these features are ignored, so that the trials are computed again.
    """
    trials_by_id: dict[str, Trial | None] = {}
    for path in own_files.TRIALS.find(root):
        try:
            entries = read_json(path)
            entries = entries[TRIALS]
            check(layouts.Trials, entries)
            trials = {name: None if values is None else _from_json(values) for name, values in entries.items()}
        except UNREADABLE:
            continue
        trials_by_id |= {
            name: trial for name, trial in trials.items() if trial is None or trial.has_features(features)
        }
    return trials_by_id


def _to_json(trial: Trial) -> dict[str, Any]:
    """Convert a trial for JSON."""
    amplitudes = {name: [[a.real, a.imag] for a in parts.tolist()] for name, parts in trial.amplitudes.items()}
    mean_squares = {name: parts.tolist() for name, parts in trial.mean_squares.items()}
    entries = {
        "passes": trial.passes,
        "turns": trial.revolutions,
        "repeats": trial.is_periodic,
        "forces": trial.forces.tolist(),
    }
    return entries | {"lines": amplitudes, "powers": mean_squares, "method": trial.method, "step": trial.step}


def _from_json(entries: Mapping[str, Any]) -> Trial:
    """Convert the entries of ``_to_json`` to a trial. Raises ``Unreadable`` if they are inconsistent."""
    amplitudes = {name: np.array([complex(*pair) for pair in parts]) for name, parts in entries["lines"].items()}
    mean_squares = {name: np.array(parts) for name, parts in entries["powers"].items()}
    method_and_step = entries.get("method", ""), entries.get("step", 0.0)
    trial = Trial(
        entries["passes"],
        entries["turns"],
        entries["repeats"],
        amplitudes,
        mean_squares,
        np.array(entries["forces"]),
        *method_and_step,
    )
    if not trial.is_consistent:
        raise Unreadable("the parts of a trial are inconsistent")
    return trial
