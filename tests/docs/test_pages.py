"""Commands, studies and Python blocks of README, start, tutorial and how-to pages run, and print what is shown.

The blocks of a page run in order in an empty folder:

- ``yaml title="FILE"`` is written into that file; other YAML is a part of a study, checked with the last file;
- ``console`` has commands after ``$`` and their output, in which ``...`` stands for any text;
- ``sh`` has commands that succeed;
- ``python`` shares one namespace in a page.

``<!-- not run: REASON -->`` on the line above leaves a block out; ``NOT_RUN`` counts these blocks.
"""

import re
import shlex
import subprocess
from collections.abc import Iterator
from doctest import ELLIPSIS, NORMALIZE_WHITESPACE, OutputChecker
from pathlib import Path

import pytest
import yaml
from sybil import Document, Example, Region
from sybil.example import SybilFailure
from sybil.parsers.markdown import PythonCodeBlockParser
from sybil.parsers.markdown.lexers import RawFencedCodeBlockLexer
from typer.testing import CliRunner

from bearingsim.cli.app import app
from bearingsim.study import StudyError, load_study
from tests.conftest import ROOT

HOW_TO = sorted(ROOT.glob("docs/howto/*.md"))
PAGES = [ROOT / "README.md", ROOT / "docs/start.md", ROOT / "docs/tutorial.md", *HOW_TO]
NOT_RUN = {
    "README.md": 2,  # installation; make demo, make test
    "docs/start.md": 1,  # installation
    "docs/howto/cluster.md": 3,  # Slurm; an accuracy, which its study lacks; dask on several machines
    "docs/howto/extension.md": 5,  # a package of the reader
    "docs/howto/other-tools.md": 2,  # a job by its id, which depends on the version; MATLAB
}
"""Blocks of a page that need an installation, a cluster, MATLAB or a package of the reader."""
MARKER = re.compile(r"<!-- not run: \S.* -->\n$")
INFO = re.compile(r'(?P<language>\w*)(?: title="(?P<title>[^"\n]+)")?[^\n]*$\n', re.MULTILINE)
OPTIONS = ELLIPSIS | NORMALIZE_WHITESPACE


def page_name(page: Path) -> str:
    """Return the path of a page in the repository."""
    return str(page.relative_to(ROOT))


def fenced(document: Document) -> Iterator[Region]:
    """Yield the fenced blocks that are run by this module, and those left out."""
    for region in RawFencedCodeBlockLexer(INFO)(document):
        if region.lexemes["language"] != "python" or is_left_out(document, region):
            region.parsed = region.lexemes["source"]
            region.evaluator = evaluate
            yield region


def python(document: Document) -> Iterator[Region]:
    """Yield the Python blocks."""
    for region in PythonCodeBlockParser(doctest_optionflags=OPTIONS)(document):
        if not is_left_out(document, region):
            yield region


def is_left_out(document: Document, region: Region) -> bool:
    """Check for a marker above a block."""
    return bool(MARKER.search(document.text[: region.start]))


def evaluate(example: Example) -> str | None:
    """Run a block; return a message if it does not do what its page shows."""
    if is_left_out(example.document, example.region):
        return None
    language, title = example.region.lexemes["language"], example.region.lexemes["title"]
    source = str(example.parsed)
    match language:
        case "yaml" | "csv" if title:
            Path(title).write_text(source, encoding="utf-8")
            example.namespace["study"] = title
        case "yaml":
            study = yaml.safe_load(Path(example.namespace["study"]).read_text(encoding="utf-8"))
            Path("part.yaml").write_text(yaml.safe_dump(study | yaml.safe_load(source)), encoding="utf-8")
            load_study("part.yaml").cases()
        case "console":
            return next(filter(None, map(difference, re.split(r"^\$ ", source, flags=re.MULTILINE)[1:])), None)
        case "sh":
            return next(filter(None, map(difference, source.strip().splitlines())), None)
        case _:
            return f"a block of `{language}`, which is not run, has no marker"
    return None


def difference(command_and_output: str) -> str | None:
    """Run a command; return how its output differs from that shown, if any is shown or the command fails."""
    command, _, expected = command_and_output.partition("\n")
    code, output = run(command)
    if not expected.strip():
        return f"{command}: exit code {code}\n{output}" if code else None
    if OutputChecker().check_output(expected, output, OPTIONS):
        return None
    return f"{command}: exit code {code}, shown\n{expected}\nprinted\n{output}"


def run(command: str) -> tuple[int, str]:
    """Run a command, ``bearingsim`` in this process; return exit code and stdout, or stderr of a failure."""
    words = shlex.split(command, comments=True)
    if words[0] == "bearingsim" and not {"|", ">"} & set(words):
        result = CliRunner().invoke(app, words[1:])
        return result.exit_code, result.stdout if result.exit_code == 0 else result.stderr
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout if done.returncode == 0 else done.stderr


def parse(page: Path) -> Document:
    """Return the blocks of a page."""
    return Document.parse(str(page), fenced, python)


def run_blocks(page: Path) -> None:
    """Run the blocks of a page in the working folder; fail at the first that does not do what the page shows."""
    for example in parse(page):
        example.evaluate()


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_blocks_of_page_run_with_shown_output(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run_blocks(page)


@pytest.mark.parametrize(
    "block",
    [
        "```console\n$ echo 12\n13\n```",
        "```console\n$ bearingsim freq nosuch\n```",
        "```sh\ntrue\nfalse\n```",
        "```python\n>>> 1 + 1\n3\n```",
        "```python\nassert 1 > 2\n```",
        "```\ntext\n```",
        '```yaml title="a.yaml"\nstudy: a\nbearing: nf308\nspeed: 1800 rpm\n```\n\n```yaml\nlaod: 150 N\n```',
    ],
)
def test_block_with_different_output_fails(block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "page.md"
    page.write_text(block + "\n", encoding="utf-8")
    with pytest.raises((SybilFailure, AssertionError, StudyError)):
        run_blocks(page)


def test_blocks_left_out_are_listed() -> None:
    documents = {page_name(page): parse(page) for page in PAGES}
    counts = {
        name: sum(is_left_out(document, example.region) for example in document)
        for name, document in documents.items()
    }
    assert {name: count for name, count in counts.items() if count} == NOT_RUN


def test_study_of_the_readme_is_shipped() -> None:
    """The figures of the README are drawn from the shipped file."""
    shipped = (ROOT / "studies/spall.yaml").read_text(encoding="utf-8")
    assert shipped[shipped.index("study:") :] in PAGES[0].read_text(encoding="utf-8")


def test_pages_are_short() -> None:
    lengths = {page_name(page): len(page.read_text(encoding="utf-8").split()) for page in PAGES}
    limits = {page_name(page): 400 for page in HOW_TO} | {"README.md": 900}
    assert {name: length for name, length in lengths.items() if length > limits.get(name, 2000)} == {}
