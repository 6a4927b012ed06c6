"""What decides a feature, in a few plain sentences, no stronger than the intervals allow."""

from collections.abc import Iterator, Sequence

import numpy as np

from bearingsim.sensitivity.intervals import Estimate
from bearingsim.sensitivity.morris import Effects
from bearingsim.sensitivity.sobol import Indices

__all__ = ["LITTLE", "leaders", "negligible", "of_effects", "of_indices"]

LITTLE = 0.05
"""What is surely under this share, of the variance or of the largest effect, hardly matters."""


def of_indices(found: Indices, feature: str, paths: Sequence[str]) -> str:
    """What decides a feature, by Sobol' indices of the parameters ``paths``."""
    texts = [
        f"`{paths[place]}`, total index {_interval(found.total, place)}, alone {_interval(found.first, place)}"
        for place in leaders(found.total)
    ]
    weak = _weak(negligible(found.total, 1.0), paths, "the variance")
    return " ".join([_deciding(texts, feature, len(paths)), *weak, _together(found.together)])


def of_effects(found: Effects, feature: str, paths: Sequence[str], unit: str = "", factor: float = 1.0) -> str:
    """What decides a feature, by Morris' effects. unit, factor (from SI): in which they are said."""
    sized = Estimate(*(factor * ends for ends in found.magnitude))
    first = leaders(found.magnitude)
    texts = [f"`{paths[place]}`, mu* {_interval(sized, place)}{f' {unit}' * bool(unit)}" for place in first]
    weak = _weak(negligible(found.magnitude, found.magnitude.low[first[0]]), paths, "that")
    slope = np.maximum(np.abs(found.mean.low), np.abs(found.mean.high))
    bent = [f"`{paths[place]}`" for place in first if found.spread.low[place] > slope[place]]
    said = [f"What {_listed(bent)} does depends on the others, or is no straight line: sigma is over mu."]
    return " ".join([_deciding(texts, feature, len(paths)), *weak, *said * bool(bent)])


def leaders(ranked: Estimate) -> list[int]:
    """The parameter with the largest value, and those whose intervals overlap with its; the largest first."""
    places = np.argsort(-ranked.value, kind="stable")
    return [int(place) for place in places if ranked.high[place] >= ranked.low[places[0]]]


def negligible(ranked: Estimate, whole: float) -> list[int]:
    """The parameters of which the whole interval lies under LITTLE of ``whole``."""
    return [int(place) for place in np.flatnonzero(ranked.high < LITTLE * whole)]


def _deciding(texts: Sequence[str], feature: str, many: int) -> str:
    """texts: of those that may decide most, of ``many`` parameters."""
    if 1 < len(texts) == many:
        told = "; ".join(texts)
        return f"Which parameter decides {feature} most is not to be told: all intervals overlap: {told}."
    if len(texts) == 1:
        return f"One parameter decides {feature} most, its interval clear of all others: {texts[0]}."
    told = "; ".join(texts)
    return f"{len(texts)} parameters decide {feature} most, in an order that their intervals leave open: {told}."


def _weak(places: Sequence[int], paths: Sequence[str], whole: str) -> Iterator[str]:
    if places:
        named = _listed([f"`{paths[place]}`" for place in places])
        yield f"{named} hardly matter{'s' * (len(places) == 1)}: surely under {100 * LITTLE:.0f} % of {whole}."


def _together(rest: Estimate) -> str:
    """What the sum of the first indices leaves."""
    share = f"1 - sum of first indices = {_interval(rest, 0)}"
    if rest.low > 0.0:
        return f"Parameters act together ({share}): moving one at a time would not show all."
    return f"Whether parameters act together cannot be told ({share})."


def _interval(found: Estimate, place: int) -> str:
    """`0.71 (0.52 to 0.97)`."""
    value, low, high = (_short(float(ends[place])) for ends in found)
    return f"{value} ({low} to {high})"


def _short(value: float) -> str:
    return f"{value:z.2f}" if abs(value) < 10.0 else f"{value:.3g}"


def _listed(texts: Sequence[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    return " and ".join(filter(None, [", ".join(texts[:-1]), *texts[-1:]]))
