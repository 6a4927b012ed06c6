"""`bearingsim stability`: failures of each method as a table, a CSV file and maps."""

from collections.abc import Sequence
from pathlib import Path

import typer

from bearingsim.cli.opening import near
from bearingsim.text.terminal import say


def chosen(
    option: str, requested: Sequence[str] | None, choices: Sequence[str], usual: Sequence[str]
) -> list[str]:
    """Return the requested words without duplicates, or ``usual`` if none are requested.

    Raises BadParameter for a word that is not in ``choices``.
    """
    for word in requested or []:
        if word not in choices:
            words = f"{', '.join(choices[:-1])} or {choices[-1]}"
            raise typer.BadParameter(f"expected {words}, got `{word}`", param_hint=option)
    return list(dict.fromkeys(requested or usual))


def show(
    models: Sequence[str] | None,
    methods: Sequence[str] | None,
    defects: Sequence[str] | None,
    quick: bool,
    folder: Path | None,
    jobs: int,
) -> None:
    """Compute the map, draw it, and print its summary and the paths of its files."""
    from bearingsim.cli.screen import print_table
    from bearingsim.plots import stability as maps
    from bearingsim.stability import judge, mapping, matrix
    from bearingsim.stability.scene import DEFECTS

    grid = matrix.QUICK if quick else matrix.FULL
    usual = matrix.QUICK_METHODS if quick else matrix.methods_known()
    every_method = matrix.methods_known()
    grid = grid._replace(defects=tuple(chosen("--pit", defects, tuple(DEFECTS), grid.defects)))
    of_models = chosen("--model", models, matrix.models_known(), matrix.QUICK_MODELS if quick else matrix.USUAL)
    by_methods = chosen("--method", methods, every_method, [name for name in usual if name in every_method])
    target = folder or Path("results") / ("stability-quick" if quick else "stability")
    path = mapping.compute(of_models, by_methods, grid, target, jobs)
    print_table(("model", "method", *judge.CLASSES), mapping.summary(path), words=2)
    say(near(path))
    for file in maps.draw_all(path):
        say(near(file))
