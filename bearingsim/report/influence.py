"""Influence of the parameters of a design on a feature, as a table and sentences."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from bearingsim.text.numbers import significant

if TYPE_CHECKING:
    from bearingsim.sensitivity import Blocks, Effects, Estimate, Indices
    from bearingsim.store import Results


class Influence(NamedTuple):
    """Influence of the parameters on a feature: heading, table with its headers, and sentences."""

    heading: str
    headers: list[str]
    rows: list[list[str]]
    texts: list[str]


def describe_influences(results: "Results", features: Sequence[str]) -> list[Influence]:
    """Estimate the influence of the parameters of a design on some features.

    Raises UserError for a design without indices or effects, or with too few jobs.
    """
    from bearingsim.sensitivity import analyse, design_of

    design_of(results)
    all_blocks = [blocks_of(results, feature) for feature in features]
    return [describe_influence(blocks, analyse(blocks)) for blocks in all_blocks]


def blocks_of(results: "Results", feature: str) -> "Blocks":
    """Collect the blocks of a feature as ``collect_blocks`` does.

    Raises SensitivityError, also if all values are zero within numerical errors.
    """
    from bearingsim.plots.units import ROUNDING_NOTE
    from bearingsim.sensitivity import SensitivityError, collect_blocks, design_of
    from bearingsim.store import all_zero

    blocks = collect_blocks(results, feature)
    table = results.table().set_index("job")
    if all_zero(table.loc[list(design_of(results)["ids"])], feature):
        raise SensitivityError(f"`{feature}` is {ROUNDING_NOTE} in all jobs, so its variance has no meaning")
    return blocks


def describe_influence(blocks: "Blocks", analysis: "Indices | Effects") -> Influence:
    """Describe an analysis of a feature."""
    return Influence(_heading(blocks), *_table(blocks, analysis), [verdict(blocks, analysis), *_remarks(blocks)])


def _heading(blocks: "Blocks") -> str:
    """Format mean, standard deviation and design of a feature.

    `velocity@BPFO: mean 14.6 um/s, standard deviation 10.1 um/s; Sobol' indices from 128 blocks, 1024 jobs`.
    """
    unit, factor = _unit(blocks)
    moments = (blocks.values.mean(), blocks.values.std())
    mean, deviation = (f"{significant(factor * float(number))} {unit}".strip() for number in moments)
    measures = "Sobol' indices" if blocks.kind == "saltelli" else "Morris' effects"
    origin = f"{measures} from {len(blocks.values)} blocks, {blocks.jobs} jobs"
    return f"{blocks.feature}: mean {mean}, standard deviation {deviation}; {origin}"


def _table(blocks: "Blocks", analysis: "Indices | Effects") -> tuple[list[str], list[list[str]]]:
    """Return headers and rows of a table: a row per parameter, the most important first; intervals in brackets."""
    from bearingsim.sensitivity import LEVEL, ROUNDING, Indices

    is_share = isinstance(analysis, Indices)
    unit, factor, digits = ("", 1.0, "z.2f") if is_share else (*_unit(blocks), ".3g")
    estimates = columns(analysis)
    headers = ["parameter"]
    for name in estimates:
        headers += [f"{name} ({unit})" if unit else name, f"{100 * LEVEL:.0f} %"]
    ranking = next(iter(estimates.values())).value
    rounding = ROUNDING * (1.0 if is_share else float(abs(blocks.values).max()))
    order = sorted(range(len(blocks.paths)), key=lambda index: -ranking[index])
    rows = [
        [
            blocks.paths[index],
            *(
                cell
                for estimate in estimates.values()
                for cell in _cells(_without_rounding(estimate, rounding), index, digits, factor)
            ),
        ]
        for index in order
    ]
    return headers, rows


def columns(analysis: "Indices | Effects") -> "dict[str, Estimate]":
    """Return the estimates of each parameter by column; the first ranks the parameters."""
    from bearingsim.sensitivity import Indices

    if isinstance(analysis, Indices):
        return {"total": analysis.total, "first": analysis.first}
    return {"mu*": analysis.mu_star, "sigma": analysis.sigma, "mu": analysis.mu}


def _without_rounding(estimate: "Estimate", rounding: float) -> "Estimate":
    """Set values and limits that are only rounding errors to zero, such as the spread of equal effects."""
    return type(estimate)(*(ends * (abs(ends) > rounding) for ends in estimate))


def _cells(estimate: "Estimate", index: int, digits: str, factor: float) -> tuple[str, str]:
    value, low, high = (f"{factor * float(bounds[index]):{digits}}" for bounds in estimate)
    return value, f"{low} .. {high}"


def verdict(blocks: "Blocks", analysis: "Indices | Effects") -> str:
    """Describe the most important parameters in a sentence."""
    from bearingsim.sensitivity import Indices, describe_effects, describe_indices

    if isinstance(analysis, Indices):
        return describe_indices(analysis, blocks.feature, blocks.paths)
    return describe_effects(analysis, blocks.feature, blocks.paths, *_unit(blocks))


def _remarks(blocks: "Blocks") -> list[str]:
    """Return remarks on dropped blocks and on chaotic jobs."""
    texts = []
    if blocks.dropped:
        texts.append(f"{blocks.describe_losses()}; indices are those of the rest")
    if blocks.chaotic:
        texts.append(
            f"{blocks.chaotic} of {blocks.jobs} jobs are chaotic, and their scatter counts as interaction"
        )
    return texts


def _unit(blocks: "Blocks") -> tuple[str, float]:
    """Return a readable unit of a feature, and its factor from SI."""
    from bearingsim.plots.labels import feature_axis

    return feature_axis(blocks.feature, float(abs(blocks.values).max()))
