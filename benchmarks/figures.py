"""Figures of README and docs: which command makes each, and all of them anew.

    python -m benchmarks.figures [NAME ...] [--long]     or: make figures
    python -m benchmarks.figures --list

Figures of studies are drawn from their results, which are computed in `results/docs` unless they are there; those
of measurements from the tables in `docs/data`. Without names, figures whose computation takes minutes are left out
unless ``--long`` is given or their results are there.
"""

import argparse
import json
import os
import runpy
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from functools import partial
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import pandas as pd
from PIL import Image

from bearingsim.plots import plot, stability
from bearingsim.store import open_results
from benchmarks import slip
from benchmarks.speed import chart
from benchmarks.speed.report import Curve, Section
from benchmarks.speed.timing import Measure
from tests.report.chromium import browser

FIGURES, RESULTS = Path("docs/figures"), Path("results/docs")
HEIGHT, COLOURS = 1300, 128
"""Height (px) and number of colours of a picture of a page."""
BEARINGSIM = (sys.executable, "-m", "bearingsim")


class OfStudy(NamedTuple):
    """Figure of a study: its file, which of its figures or of a ``kind``, options, and settings of the run."""

    study: str
    number: int = 1
    kind: str | None = None
    where: Mapping[str, str] = {}
    setting: Mapping[str, str] = {}
    takes_minutes: bool = False

    @property
    def folder(self) -> Path:
        """Results folder."""
        return RESULTS / (f"{self.study}-changed" if self.setting else self.study)

    @property
    def run(self) -> list[str]:
        """Command line that computes the results."""
        settings = [word for key, value in self.setting.items() for word in ("--set", f"{key}={value}")]
        return ["run", f"studies/{self.study}.yaml", *settings, "--out", str(self.folder)]

    @property
    def command(self) -> str:
        """Commands that make the figure."""
        words = [word for key, value in self.where.items() for word in ("--where", f"{key}={value}")]
        kind = ["--kind", self.kind, "--job", "all"] if self.kind else []
        number = "" if self.kind else f", figure {self.number}"
        plotted = shlex.join(["plot", str(self.folder), *kind, *words])
        return f"bearingsim {shlex.join(self.run)}; bearingsim {plotted}{number}"

    def make(self, path: Path) -> None:
        """Compute what is missing of the results, and draw the figure."""
        subprocess.run([*BEARINGSIM, *self.run], check=True)
        options: dict[str, Any] = {"where": self.where} if self.where else {}
        with TemporaryDirectory() as folder:
            jobs = ["all"] if self.kind else []
            files = plot(open_results(self.folder), self.kind, jobs, out=Path(folder), **options)
            shutil.copyfile(files[self.number - 1], path)


class OfPage(NamedTuple):
    """Picture of the page of results of Fig. 16 in Chromium: its width (px), and whether it is dark or printed.

    at_chart: it begins at the first chart, not at the heading.
    """

    width: int = 1280
    at_chart: bool = False
    dark: bool = False
    printed: bool = False
    takes_minutes: bool = True

    @property
    def study(self) -> OfStudy:
        """Study whose results the page shows."""
        return OfStudy("fig16_angle")

    @property
    def command(self) -> str:
        """Commands that make the picture."""
        return f"bearingsim {shlex.join(self.study.run)}; bearingsim report {self.study.folder}"

    def make(self, path: Path) -> None:
        """Compute what is missing of the results, and take the picture."""
        subprocess.run([*BEARINGSIM, *self.study.run], check=True)
        with TemporaryDirectory() as folder, browser(Path(folder) / "profile") as tab:
            page = Path(folder) / "report.html"
            subprocess.run([*BEARINGSIM, "report", str(self.study.folder), "--out", str(page)], check=True)
            tab.open(page, self.width, self.dark)
            if self.printed:
                tab.call("Emulation.setEmulatedMedia", media="print")
                tab.run("dispatchEvent(new Event('beforeprint'))")
            top = tab.run("document.querySelector('.chart').offsetTop") if self.at_chart else 0
            picture = Image.open(BytesIO(tab.picture(self.width, HEIGHT, top)))
            picture.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE).save(path, optimize=True)


class OfTable(NamedTuple):
    """Figure of a committed table: the table, the command that measures it, and the function that draws it."""

    table: Path
    measured_by: str
    draw: Callable[[Path, Path], None]
    takes_minutes: bool = False

    @property
    def command(self) -> str:
        """Commands that make the figure."""
        return f"python -m benchmarks.figures, from {self.table}, which `{self.measured_by}` measures"

    def make(self, path: Path) -> None:
        """Draw the figure."""
        self.draw(self.table, path)


class OfCommand(NamedTuple):
    """Figure without a committed table: the command that measures and draws it."""

    command: str
    takes_minutes: bool = True

    def make(self, path: Path) -> None:
        """Measure and draw."""
        programs = str(Path(sys.executable).parent)
        searched = os.pathsep.join([programs, os.environ["PATH"]])
        subprocess.run(self.command, shell=True, check=True, env=os.environ | {"PATH": searched})


def draw_stability(model: str, ending: str, table: Path, path: Path) -> None:
    """Draw the map of a model over a slot of 0.2 mm."""
    with TemporaryDirectory() as folder:
        files = stability.draw(pd.read_csv(table), model, "0.2 mm slot", Path(folder) / "map")
        shutil.copyfile(next(file for file in files if file.name.endswith(f"-{ending}.png")), path)


def draw_benchmarks(table: Path, path: Path) -> None:
    """Draw the chart of the baseline of `make bench`."""
    sections = json.loads(table.read_text(encoding="utf-8"))["sections"]
    chart.draw(
        {
            name: Section(
                measures={key: Measure(**entry) for key, entry in section["measures"].items()},
                curves=[Curve(**entry) for entry in section["curves"]],
            )
            for name, section in sections.items()
        },
        path,
    )


def draw_by_script(name: str, function: str, table: Path, path: Path) -> None:
    """Draw a table by a function of a script in docs/evidence/scripts, which takes its rows and the file."""
    rows = pd.read_csv(table)
    scripts = "docs/evidence/scripts"
    sys.path.insert(0, scripts)  # they import one another
    draw = runpy.run_path(f"{scripts}/{name}.py")[function]
    draw(rows if name == "edge_contact" else rows.to_dict("records"), path)


def script(name: str, function: str = "draw") -> OfTable:
    """Return the figure of a script's table."""
    table = Path(f"docs/data/{name}.csv")
    return OfTable(
        table, f"python docs/evidence/scripts/{name}.py --csv {table}", partial(draw_by_script, name, function)
    )


def map_of(model: str, ending: str) -> OfTable:
    """Return the figure of a map of stability."""
    return OfTable(Path("docs/data/stability.csv"), "make stability", partial(draw_stability, model, ending))


SENSITIVITY = (
    "bearingsim run studies/sensitivity.yaml --out results/docs/sensitivity && bearingsim sensitivity "
    "results/docs/sensitivity --of velocity@BPFO --of velocity@BPFO-healthy --out docs/figures/sensitivity.png"
)
SPALL = "{race: outer, shape: spall, length: 6 mm, width: 2.5 mm, depth: 30 um, grown: 60 %, seed: 1}"
FREE_RING = {"rig.ring.bends": "true", "rig.load": "{by: point}", "defect.angle": "0 deg", "model": "rollers"}
PAPER = {"fig07_08_signal": 3, "fig10_13_shapes": 4, "fig19_20_test": 2, "fig21_angle": 2}  # figures of each study

SOURCES: dict[str, OfStudy | OfPage | OfTable | OfCommand] = {
    "spall-signal.png": OfStudy("spall"),
    "spall-envelope.png": OfStudy("spall", 2),
    "spall-width.png": OfStudy("spall", 3),
    "excitations.png": OfStudy("excitations"),
    "damping.png": OfStudy("damping"),
    "surfaces.png": OfStudy("surfaces"),
    "surfaces-envelope.png": OfStudy("surfaces", 2),
    "form-length.png": OfStudy("form_length"),
    "form-width.png": OfStudy("form_width"),
    "form-angle.png": OfStudy("form_angle"),
    "tilt.png": OfStudy("tilt", kind="load", where={"defect.offset": "3 mm"}),
    "spall.png": OfStudy("paper/fig07_08_signal", kind="pit", setting={"defect": SPALL, "duration": "20 ms"}),
    **{
        f"paper/{study}-{number}.png": OfStudy(f"paper/{study}", number)
        for study, count in PAPER.items()
        for number in range(1, count + 1)
    },
    "fig16-no-clearance.png": OfStudy("fig16_angle", takes_minutes=True),
    "report-1280.png": OfPage(),
    "report-dark.png": OfPage(dark=True),
    "report-360.png": OfPage(360, at_chart=True),
    "report-print.png": OfPage(794, printed=True),
    "ring-bends.png": OfStudy("ring_bends", takes_minutes=True),
    "ring-shape.png": OfStudy("ring_bends", kind="ring", where=FREE_RING, takes_minutes=True),
    "ring-trends.png": OfStudy("ring_trends", 2, takes_minutes=True),
    "sensitivity.png": OfCommand(SENSITIVITY),
    "stability-steps.png": map_of("rollers", "steps"),
    "stability-tolerances.png": map_of("rollers", "tolerances"),
    "stability-ring-tolerances.png": map_of("ring", "tolerances"),
    "benchmarks.png": OfTable(Path("benchmarks/speed/baseline.json"), "make bench", draw_benchmarks),
    "arrow.png": script("arrow"),
    "edge_contact.png": script("edge_contact"),
    "film_damping.png": script("film_damping", "draw_figure"),
    "form_bands.png": script("form_bands"),
    "kurtogram.png": script("kurtogram"),
    "touch_down.png": script("touch_down"),
    "slip.png": OfTable(
        Path("docs/data/slip.csv"), "make slip && python -m benchmarks.slip results/slip", slip.draw_tables
    ),
}
"""Source of each figure in ``FIGURES``; those of `make speed-accuracy` are added below."""
SCENES = (
    "angle-40", "bent-ring", "bowl", "clearance", "healthy", "inner-race", "light-load", "off-centre", "slot-0.2",
    "slot-0.8", "speed-6000",
)  # fmt: skip
SOURCES |= {f"speed-accuracy-{scene}.png": OfCommand("make speed-accuracy") for scene in SCENES}


def main() -> None:
    """Make the named figures, or all whose computation is short; or list the commands."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="file in docs/figures, such as `tilt.png`")
    parser.add_argument("--long", action="store_true", help="also those that take minutes")
    parser.add_argument("--list", action="store_true", help="print the command of each figure")
    options = parser.parse_args()
    if unknown := [name for name in options.names if name not in SOURCES]:
        parser.error(f"no figure `{unknown[0]}`: {', '.join(SOURCES)}")
    for name, source in sorted(SOURCES.items()):
        if options.list:
            print(f"{name}: {source.command}")
            continue
        has_results = isinstance(source, OfStudy) and source.folder.exists()
        if name in options.names or (
            not options.names and (options.long or has_results or not source.takes_minutes)
        ):
            print(name, flush=True)
            source.make(FIGURES / name)
        elif not options.names:
            print(f"{name} left out, takes minutes: {source.command}")


if __name__ == "__main__":
    main()
