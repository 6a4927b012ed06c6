"""The chart of a run: CPU time against error, and a step over its contact forces."""

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from bearingsim.plots.style import COLOURS, MARKERS, RC
from benchmarks.speed.report import Curve, Section
from benchmarks.speed.steps import MOST

TITLES = {"rollers": "rollers: error of the ring's velocity", "planar": "planar: error of the ring's displacement"}
ERRORS = (3e-5, 3e-2)  # what of the curves is shown


def draw(sections: dict[str, Section], path: Path) -> None:
    """Draw what there is: a panel for each scene, one for the steps."""
    curves = [curve for section in sections.values() for curve in section.curves]
    scenes = [scene for scene in TITLES if any(curve.scene == scene for curve in curves)]
    bars = "steps" in sections
    if not scenes and not bars:
        return
    with matplotlib.rc_context(RC):  # type: ignore[arg-type]
        widths = [1.0] * len(scenes) + [0.7] * bars
        size = (4.4 * sum(widths), 4.6)
        figure, axes = plt.subplots(
            1, len(widths), figsize=size, width_ratios=widths, squeeze=False, layout="constrained"
        )
        for ax, scene in zip(axes[0], scenes, strict=False):
            work_precision(ax, [curve for curve in curves if curve.scene == scene])
            ax.set_title(TITLES[scene])
        if bars:
            steps_over_forces(axes[0, -1], sections["steps"])
        figure.savefig(path)
        plt.close(figure)


def work_precision(ax: Axes, curves: list[Curve]) -> None:
    """A curve each; ours filled and full, a peer's hollow and dashed, its colour that of its package."""
    packages = list(dict.fromkeys(curve.method.split()[0] for curve in curves if not curve.ours))
    own = peers = 0
    for curve in curves:
        errors, cpu_s = np.array(curve.errors), np.array(curve.cpu_s)
        shown = (errors > ERRORS[0]) & (errors < ERRORS[1])
        order = np.argsort(errors[shown])
        if curve.ours:
            style: dict[str, Any] = {"color": COLOURS[own], "marker": MARKERS[own], "linewidth": 1.8, "zorder": 3}
            own += 1
        else:
            package = packages.index(curve.method.split()[0])
            grey = str(0.15 + 0.5 * package / max(1, len(packages) - 1))
            style = {"color": grey, "marker": MARKERS[peers], "markerfacecolor": "white"}
            style |= {"linestyle": "--", "linewidth": 1.0}
            peers += 1
        ax.plot(errors[shown][order], cpu_s[shown][order], markersize=4.5, label=curve.method, **style)
    ax.set(xscale="log", yscale="log", xlabel="relative error", ylabel="CPU s for a simulated second")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3, fontsize=7.0, columnspacing=1.0)


def steps_over_forces(ax: Axes, section: Section) -> None:
    """A bar for each model, and a mark at what it is to come to."""
    seconds = {name: one.seconds for name, one in section.measures.items()}
    found = {model: seconds[f"step/{model}"] / seconds[f"forces/{model}"] for model in MOST}
    places = np.arange(len(found))
    ax.bar(places, list(found.values()), color=COLOURS[0], width=0.6)
    ax.hlines(list(MOST.values()), places - 0.4, places + 0.4, color=COLOURS[1], linewidth=2.0, label="aim")
    for place, (model, ratio) in zip(places, found.items(), strict=True):
        told = f"{ratio:.1f}
{1e9 * seconds[f'step/{model}']:.0f} ns"
        ax.text(float(place), ratio, told, ha="center", va="bottom", fontsize=7.5)
    ax.set_xticks(places, list(found))
    ax.set(ylabel="Verlet step over its contact forces", ylim=(0.0, 1.2 * max(*found.values(), *MOST.values())))
    ax.set_title("a step, bare")
    ax.grid(axis="x", visible=False)
    ax.legend(loc="upper right")
