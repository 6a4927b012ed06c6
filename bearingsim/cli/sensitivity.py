"""`bearingsim sensitivity`: what decides a feature, as a table, in words, as a figure."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.cli.opening import near
from bearingsim.cli.screen import print_table, significant
from bearingsim.errors import UserError
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.plots.sensitivity import Answer
    from bearingsim.sensitivity import Blocks, Effects, Estimate, Indices
    from bearingsim.store import Results

__all__ = ["show"]


def show(results: "Results", features: Sequence[str], as_json: bool, out: Path | None) -> None:
    """Print indices or effects of some features (default: the fault's line), and draw them.

    out: file of the figure; default: a name of its own among the results' figures, none for JSON.
    """
    from bearingsim.plots import select
    from bearingsim.sensitivity import analysed, design_of, of_results

    design_of(results)
    wanted = list(dict.fromkeys(features)) or list(select.default_y(results, results.table()))
    target = _target(results, wanted, out)
    blocks = [of_results(results, feature) for feature in wanted]
    answers = [(one, analysed(one)) for one in blocks]
    if as_json:
        say(json.dumps({one.feature: _plain(one, found) for one, found in answers}, indent=1))
    else:
        for number, answer in enumerate(answers):
            say("\n" * bool(number) + _head(*answer))
            _print(*answer)
            say(_verdict(*answer))
            for told in _remarks(answer[0]):
                say(told)
    if out is not None or not as_json:
        _draw(results, answers, target, quiet=as_json)


def _target(results: "Results", features: Sequence[str], out: Path | None) -> Path:
    """The file of the figure. Raises UserError for a name of another format, or in no folder."""
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
        say(near(file))


def _head(blocks: "Blocks", found: "Indices | Effects") -> str:
    """`velocity@BPFO: mean 14.6 um/s, standard deviation 10.1 um/s; Sobol' indices from 128 blocks, 1024 jobs`."""
    unit, factor = _unit(blocks)
    numbers = (blocks.values.mean(), blocks.values.std())
    mean, deviation = (f"{significant(factor * float(number))} {unit}".strip() for number in numbers)
    what = "Sobol' indices" if blocks.kind == "saltelli" else "Morris' effects"
    of = f"{what} from {len(blocks.values)} blocks, {blocks.jobs} jobs"
    return f"{blocks.feature}: mean {mean}, standard deviation {deviation}; {of}"


def _print(blocks: "Blocks", found: "Indices | Effects") -> None:
    """A row for each parameter, the one that matters most first; intervals in brackets."""
    from bearingsim.sensitivity import LEVEL, Indices

    unit, factor, digits = ("", 1.0, "z.2f") if isinstance(found, Indices) else (*_unit(blocks), ".3g")
    columns = _columns(found)
    heads = ["parameter"]
    for name in columns:
        heads += [f"{name} ({unit})" if unit else name, f"{100 * LEVEL:.0f} %"]
    ranked = next(iter(columns.values())).value
    order = sorted(range(len(blocks.paths)), key=lambda place: -ranked[place])
    rows = [
        [blocks.paths[place], *(cell for one in columns.values() for cell in _cells(one, place, digits, factor))]
        for place in order
    ]
    print_table(heads, rows)


def _columns(found: "Indices | Effects") -> "dict[str, Estimate]":
    """What is told of each parameter; the first is what they are ranked by."""
    from bearingsim.sensitivity import Indices

    if isinstance(found, Indices):
        return {"total": found.total, "first": found.first}
    return {"mu*": found.magnitude, "sigma": found.spread, "mu": found.mean}


def _cells(one: "Estimate", place: int, digits: str, factor: float) -> tuple[str, str]:
    value, low, high = (f"{factor * float(ends[place]):{digits}}" for ends in one)
    return value, f"{low} .. {high}"


def _verdict(blocks: "Blocks", found: "Indices | Effects") -> str:
    from bearingsim.sensitivity import Indices, of_effects, of_indices

    if isinstance(found, Indices):
        return of_indices(found, blocks.feature, blocks.paths)
    return of_effects(found, blocks.feature, blocks.paths, *_unit(blocks))


def _remarks(blocks: "Blocks") -> list[str]:
    """What is to be kept in mind: what was dropped, what is chance."""
    told = []
    if blocks.dropped:
        told.append(f"{blocks.losses()}; indices are those of the rest")
    if blocks.chaotic:
        told.append(
            f"{blocks.chaotic} of {blocks.jobs} jobs are chaotic: how far one draw differs from another counts"
            " as parameters that act together"
        )
    return told


def _unit(blocks: "Blocks") -> tuple[str, float]:
    """The unit in which a feature reads well, and its factor from SI."""
    from bearingsim.plots.labels import feature_axis

    return feature_axis(blocks.feature, float(abs(blocks.values).max()))


def _plain(blocks: "Blocks", found: "Indices | Effects") -> dict[str, Any]:
    """For JSON, in SI."""
    from bearingsim.sensitivity import Indices

    told: dict[str, Any] = {
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
            path: {name: _ends(one, place) for name, one in _columns(found).items()}
            for place, path in enumerate(blocks.paths)
        },
        "says": _verdict(blocks, found),
    }
    return told | ({"together": _ends(found.together, 0)} if isinstance(found, Indices) else {})


def _ends(one: "Estimate", place: int) -> dict[str, float]:
    return {name: float(ends[place]) for name, ends in zip(("value", "low", "high"), one, strict=True)}
