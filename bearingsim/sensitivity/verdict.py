"""Description of the influential parameters of a feature, as far as the confidence intervals justify it."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from bearingsim.sensitivity.estimates import Effects, Estimate, Indices

NEGLIGIBLE_SHARE = 0.05
"""Share of the variance, or of the lower limit of the largest effect, below which a parameter is negligible."""


def describe_indices(indices: Indices, feature: str, paths: Sequence[str]) -> str:
    """Describe the influential parameters of a feature, by Sobol' indices; paths: names of all parameters."""
    total, alone = (
        [_interval(estimate, row, _format) for row in range(len(paths))]
        for estimate in (indices.total, indices.first)
    )
    texts = [
        f"`{paths[row]}`, total index {total[row]}, alone {alone[row]}"
        for row in strongest_parameters(indices.total)
    ]
    negligible_texts = _negligible_texts(negligible_parameters(indices.total, 1.0), paths, "the variance")
    return " ".join(
        [_dominant_text(texts, feature, len(paths)), *negligible_texts, _interaction_text(indices.interaction)]
    )


def describe_effects(
    effects: Effects, feature: str, paths: Sequence[str], unit: str = "", factor: float = 1.0
) -> str:
    """Describe the influential parameters of a feature, by Morris effects.

    paths: names of all parameters; factor: from SI to ``unit``.
    """
    scaled = Estimate(*(factor * values for values in effects.mu_star))
    strongest = strongest_parameters(effects.mu_star)
    texts = [
        f"`{paths[row]}`, mu* {_interval(scaled, row, _format_small)}{f' {unit}' * bool(unit)}"
        for row in strongest
    ]
    negligible_texts = _negligible_texts(
        negligible_parameters(effects.mu_star, effects.mu_star.low[strongest[0]]), paths, "that"
    )
    largest_slope = np.maximum(np.abs(effects.mu.low), np.abs(effects.mu.high))
    nonlinear_paths = [f"`{paths[row]}`" for row in strongest if effects.sigma.low[row] > largest_slope[row]]
    nonlinear = [
        f"The effect of {_join(nonlinear_paths)} is nonlinear or depends on other parameters (sigma exceeds mu)."
    ]
    return " ".join(
        [_dominant_text(texts, feature, len(paths)), *negligible_texts, *nonlinear * bool(nonlinear_paths)]
    )


def strongest_parameters(estimate: Estimate) -> list[int]:
    """List the parameters whose intervals overlap that of the largest value, in descending order."""
    rows = np.argsort(-estimate.value, kind="stable")
    return [int(row) for row in rows if estimate.high[row] >= estimate.low[rows[0]]]


def negligible_parameters(estimate: Estimate, scale: float) -> list[int]:
    """List the parameters whose intervals lie below ``NEGLIGIBLE_SHARE`` times ``scale``."""
    return [int(row) for row in np.flatnonzero(estimate.high < NEGLIGIBLE_SHARE * scale)]


def _dominant_text(texts: Sequence[str], feature: str, count: int) -> str:
    """Describe the most influential of ``count`` parameters; texts: descriptions of those parameters."""
    if 1 < len(texts) == count:
        listed = "; ".join(texts)
        return f"No parameter clearly dominates {feature}, because all intervals overlap: {listed}."
    if len(texts) == 1:
        return f"One parameter clearly dominates {feature}: {texts[0]}."
    listed = "; ".join(texts)
    return f"{len(texts)} parameters dominate {feature}, with overlapping intervals: {listed}."


def _negligible_texts(rows: Sequence[int], paths: Sequence[str], scale: str) -> Iterator[str]:
    if rows:
        names = _join([f"`{paths[row]}`" for row in rows])
        verb = "is" if len(rows) == 1 else "are"
        yield f"{names} {verb} negligible, below {100 * NEGLIGIBLE_SHARE:.0f} % of {scale}."


def _interaction_text(interaction: Estimate) -> str:
    """Describe the interactions, from 1 minus the sum of the first-order indices."""
    share = f"1 - sum of first-order indices = {_interval(interaction, 0, _format)}"
    if interaction.low > 0.0:
        return f"Parameters interact ({share}), so varying one at a time is not enough."
    return f"Interactions of parameters are not significant ({share})."


def _interval(estimate: Estimate, row: int, text_of: Callable[[float], str]) -> str:
    """Format a value and its interval: `0.71 (0.52 to 0.97)`."""
    value, low, high = (text_of(float(values[row])) for values in estimate)
    return f"{value} ({low} to {high})"


def _format(value: float) -> str:
    return f"{value:z.2f}" if abs(value) < 10.0 else f"{value:.3g}"


def _format_small(value: float) -> str:
    """Format a value with a unit, whose magnitude may be far below 1."""
    return _format(value) if value == 0.0 or abs(value) >= 0.1 else f"{value:.2g}"


def _join(texts: Sequence[str]) -> str:
    """Join words: `a`, `a and b`, `a, b and c`."""
    return " and ".join(filter(None, [", ".join(texts[:-1]), *texts[-1:]]))
