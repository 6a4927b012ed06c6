"""Commands that need no results of a study: compile, frequencies, maps and charts of the methods."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from bearingsim.cli import completion
from bearingsim.cli.opening import short_path
from bearingsim.cli.options import SILENCE_S, Jobs, Json, check_choice
from bearingsim.text.announcer import Announcer, announcer
from bearingsim.text.terminal import say

WARM_DEFECT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
WARM_CASE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "defects": [WARM_DEFECT]}
"""Case whose solver `warm` compiles if no study is named."""


def warm(
    study: Annotated[
        Path | None, typer.Argument(metavar="STUDY", help="study file; without it, the default models")
    ] = None,
) -> None:
    """Compile the solver of a study, or of the default models, into the cache, before the first run."""
    with announcer(seconds=SILENCE_S) as announcements:
        models = _compile_solver(study, announcements)
    say(f"compiled and in the cache: {models}")


def _compile_solver(study: Path | None, announcements: Announcer) -> str:
    """Compile the solver for the cases of a study; return their models, in words.

    Without a study, compile the default model and the reference of most studies with an accuracy, both with and
    without friction. Raises StudyError.
    """
    from bearingsim.catalogue import DEFAULT_MODEL, REFERENCE
    from bearingsim.config import Case
    from bearingsim.runner.progress import compilation_callback
    from bearingsim.selection.candidates import with_friction
    from bearingsim.simulation import compile_solvers
    from bearingsim.study import load_study

    if study is not None:
        cases = load_study(study).cases()
    else:
        default_case, reference = (
            Case.model_validate(WARM_CASE | {"model": model}) for model in (DEFAULT_MODEL, REFERENCE)
        )
        cases = [default_case, reference, with_friction(reference) or reference]
    compile_solvers(cases, compilation_callback(announcements))
    return ", ".join(f"`{model}`" for model in dict.fromkeys(case.model for case in cases))


def freq(
    bearing: Annotated[
        str,
        typer.Argument(
            metavar="BEARING",
            help="name in configs/bearings, or path of a bearing file",
            autocompletion=completion.bearing,
        ),
    ],
    speed: Annotated[str, typer.Option(help="speed of the inner ring")] = "1800 rpm",
    outer_speed: Annotated[
        str | None, typer.Option(help="speed of the outer ring, negative if opposite to the inner one; default: 0")
    ] = None,
    contact_angle: Annotated[
        str | None, typer.Option(help="contact angle, such as `15 deg`; default: from the bearing file, else 0")
    ] = None,
    as_json: Json = False,
) -> None:
    """Print the characteristic frequencies of a bearing and their harmonics.

    A bearing file needs only `rollers`, `roller_diameter` and `pitch_diameter` (and `element: ball` for balls).
    """
    from bearingsim.cli import frequencies

    values = frequencies.bearing_frequencies(bearing, speed, outer_speed, contact_angle)
    if as_json:
        say(json.dumps(values, indent=1))
    else:
        frequencies.show(bearing, speed, values, outer_speed)


def stability(
    model: Annotated[
        list[str] | None, typer.Option(metavar="MODEL", help="model to map; default: ring and rollers; repeatable")
    ] = None,
    method: Annotated[
        list[str] | None,
        typer.Option(metavar="METHOD", help="integrator; default: all, including SciPy's; repeatable"),
    ] = None,
    defect: Annotated[
        list[str] | None,
        typer.Option("--pit", metavar="DEFECT", help="defect, such as `0.2 mm slot`; default: all; repeatable"),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="map a small grid of a few methods (some minutes)")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="folder (default: results/stability, or -quick)")
    ] = None,
    jobs: Jobs = 1,
) -> None:
    """Map where each integrator fails, over step, stiffness, damping and defect, as a CSV file and figures."""
    from bearingsim.cli.screen import print_table
    from bearingsim.plots import stability as maps
    from bearingsim.stability import classification, mapping, matrix
    from bearingsim.stability.scene import DEFECTS

    grid = matrix.QUICK if quick else matrix.FULL
    default_methods = matrix.QUICK_METHODS if quick else matrix.method_names()
    all_methods = matrix.method_names()
    grid = grid._replace(defects=tuple(_select("--pit", defect, tuple(DEFECTS), grid.defects)))
    model_names = _select(
        "--model", model, matrix.model_names(), matrix.QUICK_MODELS if quick else matrix.default_models()
    )
    method_names = _select(
        "--method", method, all_methods, [name for name in default_methods if name in all_methods]
    )
    target = out or Path("results") / ("stability-quick" if quick else "stability")
    path = mapping.compute_map(model_names, method_names, grid, target, jobs or 1)
    print_table(("model", "method", *classification.CLASSES), mapping.summary_rows(path), text_columns=2)
    say(short_path(path))
    for file in maps.draw_all(path):
        say(short_path(file))


def _select(
    option: str, names: Sequence[str] | None, choices: Sequence[str], defaults: Sequence[str]
) -> list[str]:
    """Return the requested names without duplicates, or ``defaults`` if none are requested.

    Raises BadParameter for a name that is not in ``choices``.
    """
    for name in names or []:
        check_choice(option, name, choices)
    return list(dict.fromkeys(names or defaults))


def bench(
    study: Annotated[
        Path | None,
        typer.Argument(metavar="STUDY", help="study whose first cases are compared; default: the built-in scenes"),
    ] = None,
    scene: Annotated[list[str] | None, typer.Option(metavar="NAME", help="built-in scene; repeatable")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="use few scenes and settings, and short records")] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="folder (default: results/bench-chart, or -quick)")
    ] = None,
    jobs: Jobs = 1,
) -> None:
    """Chart speed against accuracy of models and integrators over their steps or tolerances."""
    from bearingsim.cli import bench as bench_command

    bench_command.show(study, scene or [], quick, out, jobs or 1)
