"""Chart of a run: CPU time against error, and cost of a step relative to its contact forces."""

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from bearingsim.plots.style import COLOURS, MARKERS, RC
from benchmarks.speed.accuracy import ERRORS, PLANAR_ERROR
from benchmarks.speed.report import Curve, Section
from benchmarks.speed.steps import MAX_RATIOS

TITLES = {"rollers": "rollers: error of the ring's velocity", "planar": "planar: error of the ring's displacement"}
TARGET_ERRORS = {"rollers": ERRORS, "planar": (PLANAR_ERROR,)}  # errors at which costs are reported
ERROR_LIMITS = {"rollers": (3e-5, 2e-2), "planar": (2e-6, 3e-2)}  # range of the error axis
OWN_COLOURS, PEER_COLOURS = COLOURS[:5], (*COLOURS[5:], "0.55")


def draw(sections: dict[str, Section], path: Path) -> None:
    """Draw a panel for each scene with curves, and one for the steps."""
    curves = [curve for section in sections.values() for curve in section.curves]
    scenes = [scene for scene in TITLES if any(curve.scene == scene for curve in curves)]
    has_steps = "steps" in sections
    if not scenes and not has_steps:
        return
    with matplotlib.rc_context(RC):  # type: ignore[arg-type]
        widths = [1.0] * len(scenes) + [0.7] * has_steps
        size = (4.4 * sum(widths), 4.6)
        figure, axes = plt.subplots(
            1, len(widths), figsize=size, width_ratios=widths, squeeze=False, layout="constrained"
        )
        for ax, scene in zip(axes[0], scenes, strict=False):
            work_precision(ax, [curve for curve in curves if curve.scene == scene])
            ax.set_title(TITLES[scene])
        if has_steps:
            steps_over_forces(axes[0, -1], sections["steps"])
        figure.savefig(path)
        plt.close(figure)


def work_precision(ax: Axes, curves: list[Curve]) -> None:
    """Draw a curve per method; those of peers are dashed with hollow markers, in the colour of the package."""
    scene = curves[0].scene
    packages = list(dict.fromkeys(curve.method.split()[0] for curve in curves if not curve.ours))
    for number, curve in enumerate(curves):
        style: dict[str, Any] = {"marker": MARKERS[number % len(MARKERS)], "linestyle": "-", "linewidth": 1.8}
        style["color"] = OWN_COLOURS[number % len(OWN_COLOURS)]
        if not curve.ours:
            colour = PEER_COLOURS[packages.index(curve.method.split()[0])]
            style |= {"color": colour, "markerfacecolor": "white", "linestyle": "--", "linewidth": 1.1}
        is_shown = np.array(curve.errors) < ERROR_LIMITS[scene][1]
        errors, cpu_s = np.array(curve.errors)[is_shown], np.array(curve.cpu_s)[is_shown]
        ax.plot(errors, cpu_s, markersize=4.5, label=curve.method, **style)
    for error in TARGET_ERRORS[scene]:
        ax.axvline(error, color="0.6", linewidth=0.8, zorder=0)
    ax.set(xscale="log", yscale="log", xlim=ERROR_LIMITS[scene])
    ax.set(xlabel="relative error", ylabel="CPU s for a simulated second")
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3, fontsize=7.0, columnspacing=1.0)


def steps_over_forces(ax: Axes, section: Section) -> None:
    """Draw a bar for each model, with a mark at its target."""
    seconds = {name: measure.seconds for name, measure in section.measures.items()}
    ratios = {model: seconds[f"step/{model}"] / seconds[f"forces/{model}"] for model in MAX_RATIOS}
    positions = np.arange(len(ratios))
    ax.bar(positions, list(ratios.values()), color=COLOURS[0], width=0.6)
    ax.hlines(
        list(MAX_RATIOS.values()), positions - 0.4, positions + 0.4, color=COLOURS[1], linewidth=2.0, label="aim"
    )
    for position, (model, ratio) in zip(positions, ratios.items(), strict=True):
        label = f"{ratio:.1f}\n{1e9 * seconds[f'step/{model}']:.0f} ns"
        ax.text(float(position), ratio, label, ha="center", va="bottom", fontsize=7.5)
    ax.set_xticks(positions, list(ratios))
    ax.set(
        ylabel="Verlet step over its contact forces", ylim=(0.0, 1.2 * max(*ratios.values(), *MAX_RATIOS.values()))
    )
    ax.set_title("a step, bare")
    ax.grid(axis="x", visible=False)
    ax.legend(loc="upper right")
