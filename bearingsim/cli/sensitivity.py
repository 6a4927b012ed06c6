"""`bearingsim sensitivity`: influence of each parameter on a feature, in a table, a sentence and a figure."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.cli.opening import check_writable, short_path
from bearingsim.cli.screen import print_table
from bearingsim.errors import UserError
from bearingsim.report import influence
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.plots.sensitivity import FeatureAnalysis
    from bearingsim.sensitivity import Blocks, Effects, Estimate, Indices
    from bearingsim.store import Results


def show(results: "Results", features: Sequence[str], as_json: bool, out: Path | None) -> None:
    """Print Sobol' indices or Morris effects of features (default: ``select.default_y``); draw them.

    out: file of the figure; default: in the figures folder of the results, no figure with JSON.
    """
    from bearingsim.plots import select
    from bearingsim.sensitivity import analyse, design_of

    design_of(results)  # raises SensitivityError if the design has no indices or effects
    feature_names = list(dict.fromkeys(features)) or list(select.default_y(results, results.table()))
    target = _target(results, feature_names, out)
    all_blocks = [influence.blocks_of(results, feature) for feature in feature_names]
    analyses = [(blocks, analyse(blocks)) for blocks in all_blocks]
    if as_json:
        say(json.dumps({blocks.feature: _json_entry(blocks, analysis) for blocks, analysis in analyses}, indent=1))
    else:
        for number, feature_analysis in enumerate(analyses):
            heading, headers, rows, texts = influence.describe_influence(*feature_analysis)
            say("\n" * bool(number) + heading)
            print_table(headers, rows)
            say("\n".join(texts))
    if out is not None or not as_json:
        _draw(results, analyses, target, quiet=as_json)


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


def _draw(results: "Results", analyses: "Sequence[FeatureAnalysis]", target: Path, quiet: bool) -> None:
    from bearingsim.plots import sensitivity

    check_writable(target.parent, "--out sensitivity.png")
    target.parent.mkdir(exist_ok=True)
    file = sensitivity.draw(results, analyses, target)
    if not quiet:
        say(short_path(file))


def _json_entry(blocks: "Blocks", analysis: "Indices | Effects") -> dict[str, Any]:
    """Convert an analysis to a JSON-serialisable dict, in SI units."""
    from bearingsim.sensitivity import Indices

    entries: dict[str, Any] = {
        "design": blocks.kind,
        "blocks": len(blocks.values),
        "dropped": blocks.dropped,
        "jobs": blocks.jobs,
        "failed": blocks.failed,
        "without_value": blocks.without_value,
        "chaotic": blocks.chaotic,
        "mean": float(blocks.values.mean()),
        "standard_deviation": float(blocks.values.std()),
        "parameters": {
            path: {name: _interval(estimate, index) for name, estimate in influence.columns(analysis).items()}
            for index, path in enumerate(blocks.paths)
        },
        "verdict": influence.verdict(blocks, analysis),
    }
    return entries | (
        {"interactions": _interval(analysis.interaction, 0)} if isinstance(analysis, Indices) else {}
    )


def _interval(estimate: "Estimate", index: int) -> dict[str, float]:
    return {name: float(bounds[index]) for name, bounds in zip(("value", "low", "high"), estimate, strict=True)}
