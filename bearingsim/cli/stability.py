"""`bearingsim stability`: where each method fails, as a table, a CSV file and maps."""

from collections.abc import Sequence
from pathlib import Path

import typer

from bearingsim.cli.opening import near
from bearingsim.text.terminal import say

__all__ = ["chosen", "show"]


def chosen(option: str, asked: Sequence[str] | None, known: Sequence[str], usual: Sequence[str]) -> list[str]:
    """The words asked for, each once; all that is ``usual`` if none. Raises BadParameter for an unknown word."""
    for word in asked or []:
        if word not in known:
            words = f"{', '.join(known[:-1])} or {known[-1]}"
            raise typer.BadParameter(f"expected {words}, got `{word}`", param_hint=option)
    return list(dict.fromkeys(asked or usual))


def show(
    models: Sequence[str] | None,
    methods: Sequence[str] | None,
    pits: Sequence[str] | None,
    quick: bool,
    folder: Path | None,
    jobs: int,
) -> None:
    """Compute the map, draw it, and print what was found and where it lies."""
    from bearingsim.cli.screen import print_table
    from bearingsim.plots import stability as maps
    from bearingsim.stability import judge, mapping, matrix
    from bearingsim.stability.scene import PITS

    grid = matrix.QUICK if quick else matrix.FULL
    usual = matrix.QUICK_METHODS if quick else matrix.methods_known()
    known = matrix.methods_known()
    grid = grid._replace(pits=tuple(chosen("--pit", pits, tuple(PITS), grid.pits)))
    of = chosen("--model", models, matrix.models_known(), matrix.QUICK_MODELS if quick else matrix.USUAL)
    by = chosen("--method", methods, known, [name for name in usual if name in known])
    target = folder or Path("results") / ("stability-quick" if quick else "stability")
    path = mapping.compute(of, by, grid, target, jobs)
    print_table(("model", "method", *judge.CLASSES), mapping.summary(path), words=2)
    say(near(path))
    for file in maps.draw_all(path):
        say(near(file))
