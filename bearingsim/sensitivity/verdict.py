"""Description of the influential parameters of a feature, as far as the confidence intervals justify it."""

from collections.abc import Iterator, Sequence

import numpy as np

from bearingsim.sensitivity.estimates import Effects, Estimate, Indices

LITTLE = 0.05
"""Share of the variance or of the largest effect below which a parameter is negligible."""


def indices_text(indices: Indices, feature: str, paths: Sequence[str]) -> str:
    """Describe the influential parameters ``paths`` of a feature, by Sobol indices."""
    texts = [
        f"`{paths[row]}`, total index {_interval(indices.total, row)}, alone {_interval(indices.first, row)}"
        for row in leaders(indices.total)
    ]
    weak = _weak(negligible(indices.total, 1.0), paths, "the variance")
    return " ".join([_deciding(texts, feature, len(paths)), *weak, _together(indices.together)])


def effects_text(effects: Effects, feature: str, paths: Sequence[str], unit: str = "", factor: float = 1.0) -> str:
    """Describe the influential parameters of a feature, by Morris effects; factor: from SI to ``unit``."""
    sized = Estimate(*(factor * ends for ends in effects.magnitude))
    strongest = leaders(effects.magnitude)
    texts = [f"`{paths[row]}`, mu* {_interval(sized, row)}{f' {unit}' * bool(unit)}" for row in strongest]
    weak = _weak(negligible(effects.magnitude, effects.magnitude.low[strongest[0]]), paths, "that")
    slope = np.maximum(np.abs(effects.mean.low), np.abs(effects.mean.high))
    bent = [f"`{paths[row]}`" for row in strongest if effects.spread.low[row] > slope[row]]
    nonlinear = [f"The effect of {_listed(bent)} is nonlinear or depends on other parameters (sigma exceeds mu)."]
    return " ".join([_deciding(texts, feature, len(paths)), *weak, *nonlinear * bool(bent)])


def leaders(ranked: Estimate) -> list[int]:
    """List the parameter with the largest value and those whose intervals overlap its own, in descending order."""
    rows = np.argsort(-ranked.value, kind="stable")
    return [int(row) for row in rows if ranked.high[row] >= ranked.low[rows[0]]]


def negligible(ranked: Estimate, whole: float) -> list[int]:
    """List the parameters whose intervals lie below ``LITTLE`` times ``whole``."""
    return [int(row) for row in np.flatnonzero(ranked.high < LITTLE * whole)]


def _deciding(texts: Sequence[str], feature: str, many: int) -> str:
    """Describe the most influential of ``many`` parameters; texts: one for each influential parameter."""
    if 1 < len(texts) == many:
        listed = "; ".join(texts)
        return f"No parameter clearly dominates {feature}, because all intervals overlap: {listed}."
    if len(texts) == 1:
        return f"One parameter clearly dominates {feature}: {texts[0]}."
    listed = "; ".join(texts)
    return f"{len(texts)} parameters dominate {feature}, with overlapping intervals: {listed}."


def _weak(rows: Sequence[int], paths: Sequence[str], whole: str) -> Iterator[str]:
    if rows:
        named = _listed([f"`{paths[row]}`" for row in rows])
        verb = "is" if len(rows) == 1 else "are"
        yield f"{named} {verb} negligible, below {100 * LITTLE:.0f} % of {whole}."


def _together(rest: Estimate) -> str:
    """Describe the interactions, from 1 minus the sum of the first-order indices."""
    share = f"1 - sum of first indices = {_interval(rest, 0)}"
    if rest.low > 0.0:
        return f"Parameters interact ({share}), so varying one at a time is not enough."
    return f"Interactions of parameters are not significant ({share})."


def _interval(estimate: Estimate, row: int) -> str:
    """Format a value and its interval: `0.71 (0.52 to 0.97)`."""
    value, low, high = (_short(float(ends[row])) for ends in estimate)
    return f"{value} ({low} to {high})"


def _short(value: float) -> str:
    return f"{value:z.2f}" if abs(value) < 10.0 else f"{value:.3g}"


def _listed(texts: Sequence[str]) -> str:
    """Join words: `a`, `a and b`, `a, b and c`."""
    return " and ".join(filter(None, [", ".join(texts[:-1]), *texts[-1:]]))
