"""`bearingsim sensitivity`: influence of each parameter on a feature, as a table, a sentence and a figure."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.cli.opening import short_path
from bearingsim.cli.screen import print_table
from bearingsim.errors import UserError
from bearingsim.text.numbers import significant
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.plots.sensitivity import Answer
    from bearingsim.sensitivity import Blocks, Effects, Estimate, Indices
    from bearingsim.store import Results


def show(results: "Results", features: Sequence[str], as_json: bool, out: Path | None) -> None:
    """Print Sobol' indices or Morris' effects of some features (default: the defect's line), and draw them.

    out: file of the figure; default: in the figures folder of the results, none with JSON.
    """
    from bearingsim.plots import select
    from bearingsim.sensitivity import analyse, collect_blocks, design_of

    design_of(results)
    feature_names = list(dict.fromkeys(features)) or list(select.default_y(results, results.table()))
    target = _target(results, feature_names, out)
    all_blocks = [collect_blocks(results, feature) for feature in feature_names]
    answers = [(blocks, analyse(blocks)) for blocks in all_blocks]
    if as_json:
        say(json.dumps({blocks.feature: _json_entry(blocks, analysis) for blocks, analysis in answers}, indent=1))
    else:
        for number, answer in enumerate(answers):
            say("\n" * bool(number) + _heading(*answer))
            _print(*answer)
            say(_verdict(*answer))
            for text in _remarks(answer[0]):
                say(text)
    if out is not None or not as_json:
        _draw(results, answers, target, quiet=as_json)


def _target(results: "Results", features: Sequence[str], out: Path | None) -> Path:
    """Return the file of the figure. Raises UserError for a wrong suffix, or a missing folder."""
    from bearingsim.plots.plot import FIGURES, FORMATS, slug

    if out is None:
        return results.path / FIGURES / f"{slug(['sensitivity', *features])}.png"
    if out.suffix.removeprefix(".").lower() not in FORMATS:
        raise UserError(f"{out}: expected a name that ends in .{', .'.join(FORMATS[:-1])} or .{FORMATS[-1]}")
    if not out.parent.is_dir():
        raise UserError(f"{out}: there is no folder {out.parent}")
    return out


def _draw(results: "Results", answers: "Sequence[Answer]", target: Path, quiet: bool) -> None:
    from bearingsim.plots import sensitivity

    target.parent.mkdir(exist_ok=True)
    file = sensitivity.draw(results, answers, target)
    if not quiet:
        say(short_path(file))


def _heading(blocks: "Blocks", analysis: "Indices | Effects") -> str:
    """Format mean, standard deviation and design of a feature.

    `velocity@BPFO: mean 14.6 um/s, standard deviation 10.1 um/s; Sobol' indices from 128 blocks, 1024 jobs`.
    """
    unit, factor = _unit(blocks)
    moments = (blocks.values.mean(), blocks.values.std())
    mean, deviation = (f"{significant(factor * float(number))} {unit}".strip() for number in moments)
    measures = "Sobol' indices" if blocks.kind == "saltelli" else "Morris' effects"
    origin = f"{measures} from {len(blocks.values)} blocks, {blocks.jobs} jobs"
    return f"{blocks.feature}: mean {mean}, standard deviation {deviation}; {origin}"


def _print(blocks: "Blocks", analysis: "Indices | Effects") -> None:
    """Print a row for each parameter, the most important first; intervals in brackets."""
    from bearingsim.sensitivity import LEVEL, Indices

    unit, factor, digits = ("", 1.0, "z.2f") if isinstance(analysis, Indices) else (*_unit(blocks), ".3g")
    columns = _columns(analysis)
    heads = ["parameter"]
    for name in columns:
        heads += [f"{name} ({unit})" if unit else name, f"{100 * LEVEL:.0f} %"]
    ranking = next(iter(columns.values())).value
    order = sorted(range(len(blocks.paths)), key=lambda index: -ranking[index])
    rows = [
        [
            blocks.paths[index],
            *(cell for estimate in columns.values() for cell in _cells(estimate, index, digits, factor)),
        ]
        for index in order
    ]
    print_table(heads, rows)


def _columns(analysis: "Indices | Effects") -> "dict[str, Estimate]":
    """Return the estimates of each parameter by column; the first ranks the parameters."""
    from bearingsim.sensitivity import Indices

    if isinstance(analysis, Indices):
        return {"total": analysis.total, "first": analysis.first}
    return {"mu*": analysis.magnitude, "sigma": analysis.spread, "mu": analysis.mean}


def _cells(estimate: "Estimate", index: int, digits: str, factor: float) -> tuple[str, str]:
    value, low, high = (f"{factor * float(bounds[index]):{digits}}" for bounds in estimate)
    return value, f"{low} .. {high}"


def _verdict(blocks: "Blocks", analysis: "Indices | Effects") -> str:
    from bearingsim.sensitivity import Indices, effects_text, indices_text

    if isinstance(analysis, Indices):
        return indices_text(analysis, blocks.feature, blocks.paths)
    return effects_text(analysis, blocks.feature, blocks.paths, *_unit(blocks))


def _remarks(blocks: "Blocks") -> list[str]:
    """Return remarks on dropped blocks and on chaotic jobs."""
    texts = []
    if blocks.dropped:
        texts.append(f"{blocks.losses()}; indices are those of the rest")
    if blocks.chaotic:
        texts.append(
            f"{blocks.chaotic} of {blocks.jobs} jobs are chaotic, and their scatter counts as interaction"
        )
    return texts


def _unit(blocks: "Blocks") -> tuple[str, float]:
    """Return a readable unit of a feature, and its factor from SI."""
    from bearingsim.plots.labels import feature_axis

    return feature_axis(blocks.feature, float(abs(blocks.values).max()))


def _json_entry(blocks: "Blocks", analysis: "Indices | Effects") -> dict[str, Any]:
    """Convert an analysis for JSON, in SI."""
    from bearingsim.sensitivity import Indices

    entries: dict[str, Any] = {
        "design": blocks.kind,
        "blocks": len(blocks.values),
        "dropped": blocks.dropped,
        "jobs": blocks.jobs,
        "failed": blocks.failed,
        "without_value": blocks.valueless,
        "chaotic": blocks.chaotic,
        "mean": float(blocks.values.mean()),
        "standard_deviation": float(blocks.values.std()),
        "parameters": {
            path: {name: _interval(estimate, index) for name, estimate in _columns(analysis).items()}
            for index, path in enumerate(blocks.paths)
        },
        "says": _verdict(blocks, analysis),
    }
    return entries | ({"together": _interval(analysis.interaction, 0)} if isinstance(analysis, Indices) else {})


def _interval(estimate: "Estimate", index: int) -> dict[str, float]:
    return {name: float(bounds[index]) for name, bounds in zip(("value", "low", "high"), estimate, strict=True)}
