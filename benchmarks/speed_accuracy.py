"""Chart of ``bearingsim bench`` for docs/speed-accuracy.md, with the peers of ``make bench`` in one scene.

    python -m benchmarks.speed_accuracy [--quick] [--jobs N] [--out results/bench-chart]

Text and figures of the full chart are copied into docs/; those of `--quick` are not.
"""

import argparse
import shutil
import time
from pathlib import Path

import numpy as np

from bearingsim.bench import external, report
from bearingsim.bench.plan import Setting, Settings
from bearingsim.cli.bench import draw_chart
from benchmarks.speed import peers

DOCS = Path(__file__).parents[1] / "docs"
SCENE = "slot-0.8"
SOLVERS = {
    "CVODE Adams": "scikit-sundae",
    "CVODE BDF": "scikit-sundae",
    "numbalsoda lsoda": "numbalsoda",
    "numbalsoda dop853": "numbalsoda",
}
"""Solvers of ``peers.solvers`` other than SciPy's, with their packages."""
SCIPY_SETTINGS: Settings = {
    "scipy-lsoda": (Setting(tolerance=1e-3), Setting(tolerance=1e-5)),
    "scipy-dop853": (Setting(tolerance=1e-3),),
}
TOLERANCES, QUICK_TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7), (1e-5, 1e-6)


def solver(name: str) -> external.Solver:
    """Adapt a peer to the chart; it gives no access to steps, and so no largest force."""

    def solve(equations: external.Equations) -> external.Solution:
        problem = peers.problem(equations.model, equations.y, equations.instants)
        problem.derivatives(
            0.0, problem.u, np.empty_like(problem.u), problem.y.copy()
        )  # compiles, before the clock starts
        integrate = dict(peers.solvers(problem))[name]
        began = time.thread_time()
        try:
            states = integrate(float(equations.tolerances.rtol))
        except RuntimeError as error:
            raise external.SolverStopped(str(error)) from error
        return external.Solution(to_si(states.T, int(equations.model.bearing.Z)), time.thread_time() - began)

    return solve


def to_si(states: np.ndarray, Z: int) -> np.ndarray:
    """Convert the states of a peer (rollers, ring; um, then m/s) to those of the chart (ring first, SI)."""
    positions, velocities = states[: Z + 2] * peers.MICRO, states[Z + 2 :]
    order = [Z, Z + 1, *range(Z)]
    return np.concatenate([positions[order], velocities[order]])


def settings(quick: bool) -> Settings:
    """Return the installed peers with some tolerances."""
    missing = peers.missing_peers()
    points = tuple(Setting(tolerance=tolerance) for tolerance in (QUICK_TOLERANCES if quick else TOLERANCES))
    peer_settings = {name: points for name, package in SOLVERS.items() if package not in missing}
    return peer_settings if quick else {**SCIPY_SETTINGS, **peer_settings}


def main() -> None:
    """Compute the chart and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    folder = options.out or Path("results") / ("bench-chart-quick" if options.quick else "bench-chart")
    peer_settings = settings(options.quick)
    external.SOLVERS.update({name: solver(name) for name in peer_settings if name in SOLVERS})
    missing = {name: reason for name, reason in peers.missing_peers().items() if name in SOLVERS.values()}
    files = draw_chart(None, [], options.quick, folder, options.jobs, {SCENE: peer_settings}, missing)
    print(*files, sep="\n")
    if not options.quick:
        copy_to_docs(folder)


def copy_to_docs(folder: Path) -> None:
    """Copy text and figures into the documentation."""
    for figure in sorted(folder.glob("speed-accuracy-*.png")):
        shutil.copyfile(figure, DOCS / "figures" / figure.name)
    text = (folder / report.FILE_NAME).read_text(encoding="utf-8")
    page = DOCS / report.FILE_NAME
    page.write_text(text.replace("](speed-accuracy-", "](figures/speed-accuracy-"), encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
