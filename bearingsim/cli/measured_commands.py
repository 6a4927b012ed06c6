"""Commands that read measured signals: analyze, compare."""

from pathlib import Path
from typing import Annotated

import typer

from bearingsim.cli import completion
from bearingsim.cli.opening import find_job, find_results, reads_results
from bearingsim.cli.options import Json

MeasuredFile = Annotated[
    Path,
    typer.Argument(
        metavar="FILE", help="csv, lvm, wav, mat, npz, parquet, h5, uff or tdms file", show_default=False
    ),
]
Bearing = Annotated[
    str | None,
    typer.Option(
        metavar="BEARING",
        help="name in configs/bearings, or path of a bearing file; required",
        autocompletion=completion.bearing,
        show_default=False,
    ),
]
Rate = Annotated[
    str | None, typer.Option(metavar="RATE", help="sampling rate, such as `51.2 kHz`; default: from the file")
]


Speed = Annotated[
    str | None,
    typer.Option(metavar="SPEED", help="speed of the shaft, such as `1796 rpm`; default: from the file"),
]
Unit = Annotated[str | None, typer.Option(metavar="UNIT", help="unit of the samples, such as `g`")]
FullScale = Annotated[
    float | None,
    typer.Option(metavar="VALUE", help="largest value of integer samples (wav), in the unit of `--unit`"),
]


def analyze(
    file: MeasuredFile,
    bearing: Bearing = None,
    speed: Speed = None,
    rate: Rate = None,
    channel: Annotated[str | None, typer.Option(metavar="NAME", help="channel; default: all")] = None,
    unit: Unit = None,
    full_scale: FullScale = None,
    tolerance: Annotated[
        str, typer.Option(metavar="SHARE", help="largest deviation of a line, 0.5 % to 4 %")
    ] = "2 %",
    band: Annotated[
        str | None,
        typer.Option(
            metavar="BAND",
            help="band of the envelope, `2-5 kHz` or `kurtogram`; default: 1 kHz to 0.4 of the rate",
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="draw time signal, spectrum, envelope and kurtogram (.png, .svg, .pdf)"),
    ] = None,
    as_json: Json = False,
) -> None:
    """Diagnose a bearing from a measured signal: which race is damaged, with the evidence.

    A race is named if three harmonics of its line stand out in two envelope spectra, above the level that 1 % of
    healthy signals reach, and no other periodicity of the signal is stronger.
    """
    from bearingsim.cli import analysis

    request = analysis.make_request(rate, speed, unit, full_scale, channel)
    analysis.show(
        file, bearing, request, analysis.parse_tolerance(tolerance), analysis.parse_band(band), figure, as_json
    )


@reads_results
def compare(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="results folder", show_default=False)],
    file: MeasuredFile,
    job: Annotated[
        str | None,
        typer.Option(
            metavar="JOB",
            help="job to compare; default: the only one with a defect",
            autocompletion=completion.job,
        ),
    ] = None,
    y: Annotated[
        str | None, typer.Option(metavar="CHANNEL", help="channel of the job; default: the first acceleration")
    ] = None,
    speed: Speed = None,
    rate: Rate = None,
    channel: Annotated[str | None, typer.Option(metavar="NAME", help="channel of the file")] = None,
    unit: Unit = None,
    full_scale: FullScale = None,
    scale: Annotated[
        bool, typer.Option("--scale", help="scale the simulated signal to the measured RMS, and print the factor")
    ] = False,
    figure: Annotated[
        Path | None, typer.Option(metavar="FILE", help="draw signals, spectra and envelopes (.png, .svg, .pdf)")
    ] = None,
    as_json: Json = False,
) -> None:
    """Compare a job with a measured signal: RMS, crest factor, defect frequency, and time from entry to exit.

    Both are compared in the band in which neither is altered by its sampling. Nothing is scaled without `--scale`.
    """
    from bearingsim.cli import analysis, comparing

    study_results = find_results(results)
    chosen = find_job(study_results, job) if job is not None else comparing.only_job(study_results)
    request = analysis.make_request(rate, speed, unit, full_scale, channel)
    comparing.show(study_results, chosen, file, request, y, scale, figure, as_json)
