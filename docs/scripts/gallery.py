"""Gallery page: every committed figure with what it shows, and the study or command that makes it."""

import re
from collections.abc import Iterator
from itertools import groupby

import yaml

from benchmarks.figures import SOURCES, OfStudy, OfTable
from docs.scripts.markdown import page
from docs.scripts.navigation import DOCS

SECTIONS: dict[str, dict[str, str]] = yaml.safe_load((DOCS / "scripts/gallery.yaml").read_text(encoding="utf-8"))
"""Caption of each figure by section."""


def gallery_page() -> str:
    """Return the page of all committed figures."""
    parts = [part for title, captions in SECTIONS.items() for part in (f"## {title}", *_section(captions))]
    return page(
        "Gallery",
        "Every figure of this documentation, with the study and the commands that make it. `make figures` draws"
        " them again in a clone of the repository, where the studies are in `studies/`.",
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
        commands = f"{source.measured_by}; make figures NAME={name}"
    else:
        commands = re.sub(r", figure \d+$", "", source.command)
    return "\n".join(re.split(r"; | && ", commands))
