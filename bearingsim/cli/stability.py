"""`bearingsim stability`: failures of each method as a table, a CSV file and maps."""

from collections.abc import Sequence
from pathlib import Path

from bearingsim.cli.opening import short_path
from bearingsim.cli.options import check_choice
from bearingsim.text.terminal import say


def select(option: str, names: Sequence[str] | None, choices: Sequence[str], defaults: Sequence[str]) -> list[str]:
    """Return the requested names without duplicates, or ``defaults`` if none are requested.

    Raises BadParameter for a name that is not in ``choices``.
    """
    for name in names or []:
        check_choice(option, name, choices)
    return list(dict.fromkeys(names or defaults))


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
    from bearingsim.stability import classification, mapping, matrix
    from bearingsim.stability.scene import DEFECTS

    grid = matrix.QUICK if quick else matrix.FULL
    default_methods = matrix.QUICK_METHODS if quick else matrix.method_names()
    all_methods = matrix.method_names()
    grid = grid._replace(defects=tuple(select("--pit", defects, tuple(DEFECTS), grid.defects)))
    model_names = select(
        "--model", models, matrix.model_names(), matrix.QUICK_MODELS if quick else matrix.default_models()
    )
    method_names = select(
        "--method", methods, all_methods, [name for name in default_methods if name in all_methods]
    )
    target = folder or Path("results") / ("stability-quick" if quick else "stability")
    path = mapping.compute(model_names, method_names, grid, target, jobs)
    print_table(("model", "method", *classification.CLASSES), mapping.summary(path), text_columns=2)
    say(short_path(path))
    for file in maps.draw_all(path):
        say(short_path(file))
