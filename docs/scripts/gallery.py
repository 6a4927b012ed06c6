"""Gallery page: every committed figure with what it shows, and the study or command that makes it."""

import re
from collections.abc import Iterator
from itertools import groupby

from benchmarks.figures import SOURCES, OfStudy, OfTable
from docs.scripts.markdown import page
from docs.scripts.navigation import DOCS

SECTIONS: dict[str, dict[str, str]] = {
    "A defect in the inner race": {
        "spall-signal.png": "Each roller that crosses the defect in the load zone makes an impact. The defect turns with"
        " the shaft, so impacts come in groups, once per turn.",
        "spall-envelope.png": "The envelope spectrum has peaks at BPFI and its multiples, with sidebands at the shaft"
        " frequency.",
        "spall-width.png": "The amplitude at BPFI grows with the width of the defect; the healthy bearing has none.",
    },
    "Figures of the paper": {
        "paper/fig07_08_signal-1.png": "Fig. 7: an impact per ball pass, 6.3 ms apart.",
        "paper/fig07_08_signal-2.png": "Fig. 8: all lines are multiples of BPFO.",
        "paper/fig07_08_signal-3.png": "Fig. 8, whole band: the lines grow towards 6 kHz, where ring and contacts"
        " resonate.",
        "paper/fig10_13_shapes-1.png": "Fig. 10: rectangle and triangle give the same velocity, the bowl a smaller one.",
        "paper/fig10_13_shapes-2.png": "Fig. 11: the contact force of a roller through the load zone. It falls to zero"
        " in the defect at 0 deg.",
        "paper/fig10_13_shapes-3.png": "Fig. 12: the same near the defect. The impact is at the exit; there is none at"
        " the entry.",
        "paper/fig10_13_shapes-4.png": "Fig. 13: the ring moves by 0.1 um and rings.",
        "paper/fig19_20_test-1.png": "Fig. 19: sampled at 1024 Hz, as in the test, single impacts are not resolved.",
        "paper/fig19_20_test-2.png": "Fig. 20: only BPFO and its second harmonic are left in that band.",
        "paper/fig21_angle-1.png": "Fig. 21: from the second harmonic on the lines fall as the defect moves out of the"
        " load zone.",
        "paper/fig21_angle-2.png": "The line at BPFO does not fall steadily: that of the healthy bearing adds to it"
        " with a phase that turns with the angle.",
        "fig16-no-clearance.png": "Fig. 16: less the healthy line (right) the amplitude falls smoothly with the angle."
        " Bands show the effect of contact damping from 0.5 to 10 us.",
    },
    "Defects and excitations": {
        "spall.png": "A spall grown by seeded bowls, and the path of a rigid roller over two sections: the roller"
        " bridges what is narrower than itself.",
        "tilt.png": "A defect 3 mm off the middle unloads one part of the roller, which tilts by 7 urad.",
        "excitations.png": "Forms of the literature over one slot. Without the rollers' inertia they agree within 15 %;"
        " with it those that end in a step give forces of kilonewtons.",
        "edge_contact.png": "A contact at an edge is up to twice as compliant as on the race; `elastic-edge` follows the"
        " finite elements.",
    },
    "Damping and sensitivity": {
        "damping.png": "Line, RMS and largest force for each damping law. Loaded rollers hardly depend on it, lightly"
        " loaded ones and large balls do.",
        "film_damping.png": "The closed form of an oil film's damping against solutions of the lubricated contact.",
        "sensitivity.png": "The BPFO line depends on clearance and load, its change from healthy on angle and width of"
        " the defect.",
    },
    "Flexible ring": {
        "ring-shape.png": "A free ring under a point load. Over the defect the race sinks between the neighbours of the"
        " unloaded roller.",
        "ring-bends.png": "The line over the angle of the defect, for six supports. On two pads it rises first.",
        "ring-trends.png": "The line over the depth of a slot, for nine supports: it saturates later on a softer ring.",
    },
    "Slip": {
        "slip.png": "The slip of the cage has a floor of 0.2 %, and becomes gross below a load that rises with speed."
        " Lines: balance of friction and drag.",
    },
    "Speed against accuracy": {
        "speed-accuracy-healthy.png": "A healthy bearing: `static` and `ring` are within 5 % at a tenth of the cost.",
        "speed-accuracy-slot-0.2.png": "A slot of 0.2 mm: `ring` gives the line within 5 %, `rollers` everything within"
        " 1 %.",
        "speed-accuracy-slot-0.8.png": "A slot of 0.8 mm: only models with the rollers' inertia are within 5 %.",
        "speed-accuracy-angle-40.png": "The same at 40 deg: for 1 % friction and slip count, so `planar` is needed.",
        "speed-accuracy-clearance.png": "The same with 10 um of clearance: `ring` is sufficient for the line.",
        "speed-accuracy-bowl.png": "A bowl: `ring` gives the line within 5 %.",
        "speed-accuracy-bent-ring.png": "A flexible ring in its housing: 40 harmonics for 1 %.",
        "speed-accuracy-speed-6000.png": "6000 rpm: a crossing takes only 81 us, and steps are shorter.",
        "speed-accuracy-light-load.png": "20 N with clearance: rollers bounce, and the motion is chaotic.",
        "speed-accuracy-off-centre.png": "A defect at the roller's end: 4 slices of `spatial` are within 5 %.",
        "speed-accuracy-inner-race.png": "A slot in the inner race: nothing is periodic, so all is computed in full.",
    },
    "Integrators": {
        "benchmarks.png": "Cost against error beside SciPy, CVODE, numbalsoda and EXUDYN, and the cost of a step.",
        "stability-steps.png": "Outcome of methods with a fixed step: they fail above the black line, where theory says.",
        "stability-tolerances.png": "Outcome of adaptive methods: SciPy's step over defects and report success.",
        "stability-ring-tolerances.png": "The same for `ring`: a dashpot that acts in full at touch-down has no"
        " solution.",
        "touch_down.png": "A contact that closes limits the order of every method to 2 to 2.5.",
        "arrow.png": "An implicit step costs less than in proportion to the number of rollers; a dense solver is 50 to"
        " 300 times slower.",
    },
}
"""What to see in each figure, by section."""


def gallery_page() -> str:
    """Return the page of all committed figures."""
    parts = [part for title, captions in SECTIONS.items() for part in (f"## {title}", *_section(captions))]
    return page(
        "Gallery",
        "Every figure of this documentation, with the study and the commands that make it. `make figures` draws them"
        " anew in a clone of the repository, where the studies are in `studies/`.",
        *parts,
    )


def _section(captions: dict[str, str]) -> Iterator[str]:
    """Yield the figures with their captions; after those of the same commands the commands and the study."""
    for commands, names in groupby(captions, _commands):
        source = None
        for name in names:
            yield f"![{_subject(captions[name])}](figures/{name})"
            yield captions[name]
            source = SOURCES[name]
        yield f"```sh\n{commands}\n```"
        if isinstance(source, OfStudy):
            yield _study(source.study)


def _subject(caption: str) -> str:
    """Return the first sentence of a caption, without the number of the figure."""
    return re.sub(r"^Fig\. [^:]*: ", "", caption).split(". ")[0].rstrip(".")


def _study(name: str) -> str:
    """Return a study without its comment at the beginning, folded up."""
    text = (DOCS.parent / f"studies/{name}.yaml").read_text(encoding="utf-8")
    lines = re.sub(r"\A(#.*\n)+\n*", "", text).rstrip()
    summary = f"<summary>studies/{name}.yaml</summary>"
    return f'<details markdown="1">{summary}\n\n```yaml\n{lines}\n```\n\n</details>'


def _commands(name: str) -> str:
    """Return the commands that make a figure, one a line."""
    source = SOURCES[name]
    if isinstance(source, OfTable):
        return f"{source.measured_by}\nmake figures NAME={name}"
    return "\n".join(re.split(r"; | && ", re.sub(r", figure \d+$", "", source.command)))
