"""Commands that need no results of a study: compile, frequencies, maps and charts of the methods."""

import json
from pathlib import Path
from typing import Annotated

import typer

from bearingsim.cli import completion
from bearingsim.cli.options import SILENCE_S, Jobs, Json
from bearingsim.text.announcer import announcer
from bearingsim.text.terminal import say


def warm(
    study: Annotated[
        Path | None, typer.Argument(metavar="STUDY", help="study file; without it, the default models")
    ] = None,
) -> None:
    """Compile the solver of a study, or of the default models, into the cache, before the first run."""
    from bearingsim.cli.warm import compile_solver

    with announcer(seconds=SILENCE_S) as announcements:
        models = compile_solver(study, announcements)
    say(f"compiled and in the cache: {models}")


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
    from bearingsim.cli import stability as stability_command

    stability_command.show(model, method, defect, quick, out, jobs or 1)


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
