"""Language of the code: docstrings of functions begin with a verb, others with a noun; names describe content."""

import ast
import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TOP = "."
"""The modules of the package itself, outside all subpackages."""
PACKAGES = (  # packages checked; add a package once it passes
    TOP, "assemble", "bench", "cli", "config", "core", "diagnosis", "measured", "plots", "report", "runner",
    "selection", "sensitivity", "signals", "simulation", "stability", "store", "study", "text",
)  # fmt: skip
NO_NOUNS = frozenset({"What", "How", "Who", "Where", "Which", "Whether"})  # openings of a clause instead of a noun
NO_VERBS = frozenset({  # openings of a docstring that are no imperative
    "what", "who", "which", "where", "when", "how", "whether", "why", "one", "ones", "those", "these",
    "this", "that", "there", "it", "its", "their", "they", "a", "an", "the", "all", "each", "every",
    "some", "any", "no", "nothing", "of", "for", "by", "in", "on", "to", "with", "from", "as", "at",
    "if", "is", "are", "not",
    # nouns and adjectives that once stood first
    "amplitude", "angle", "complex", "depth", "distance", "everything", "first", "frequency", "height", "index",
    "largest", "least", "mass", "number", "pattern", "phase", "regular", "relative", "rms", "room", "schema", "si",
    "spectrum", "squared", "standard", "time", "validator", "width", "windowed",
    "acceleration", "angular", "damping", "density", "displacement", "elastic", "exact", "friction", "integral",
    "kernel", "kinetic", "mean", "net", "radial", "scalar", "solution", "spectral", "third", "torque", "two",
    "velocity", "viscosity",
})  # fmt: skip
VERBS_IN_S = frozenset({"pass", "process", "compress", "express", "discuss", "address", "guess", "assess", "bias"})
VAGUE_NAMES = frozenset(
    {"found", "told", "one", "known", "given", "here", "asked", "said", "at", "first", "seen", "wanted", "kept"}
)
PRIVATE_WORDS = re.compile(r"(?i)(?<![a-z])(places?|leans?|twins?)(?![a-z])")
"""Words that the field does not use for a position, a tilt or a healthy case."""


def source_files(package: str) -> list[Path]:
    """Return the source files of a package of the program."""
    root = ROOT / "bearingsim"
    return sorted(root.glob("*.py") if package == TOP else (root / package).rglob("*.py"))


def test_vague_names_are_recognised() -> None:
    source = "found = 1\nfor one in x: pass\ndef f(given): pass\ntry: pass\nexcept E as said: pass\n"
    assert len(list(vague_names(ast.parse(source)))) == 4


def is_property(function: ast.FunctionDef) -> bool:
    """Check if a method is read like a field."""
    names = {ast.unparse(decorator).split("(")[0].split(".")[-1] for decorator in function.decorator_list}
    return bool(names & {"property", "cached_property", "setter"})


def is_imperative(sentence: str) -> bool:
    """Check if the first word of a docstring may be an imperative verb."""
    word = sentence.split()[0].rstrip(",.:;")
    third_person = word.endswith("s") and word.lower() not in VERBS_IN_S
    return word.isalpha() and word[0].isupper() and word.lower() not in NO_VERBS and not third_person


def odd_openings(tree: ast.Module) -> Iterator[str]:
    """List functions whose docstring does not begin with an imperative."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and not is_property(node):
            text = ast.get_docstring(node)
            if text and not is_imperative(text):
                yield f"{node.lineno} {node.name}: {text.splitlines()[0]}"


def docstrings(tree: ast.Module) -> Iterator[tuple[ast.AST, str]]:
    """List the module, its classes, properties and constants with their docstrings."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and is_property(node):
            yield node, ast.get_docstring(node) or ""
        if isinstance(node, ast.Module | ast.ClassDef):
            yield node, ast.get_docstring(node) or ""
            for constant, text in pairwise(node.body):
                match constant, text:
                    case (ast.Assign() | ast.AnnAssign(), ast.Expr(value=ast.Constant(value=str(docstring)))):
                        yield constant, docstring


def clauses(tree: ast.Module) -> Iterator[str]:
    """List docstrings that begin with a clause instead of a noun."""
    for node, text in docstrings(tree):
        if text and text.split()[0].rstrip(",.:;") in NO_NOUNS:
            yield f"{getattr(node, 'lineno', 1)} {text.splitlines()[0]}"


def vague_names(tree: ast.Module) -> Iterator[str]:
    """List names bound by assignment, loop, ``with``, comprehension, ``except``, ``match`` or as a parameter.

    Fields of classes are left out, because they are read behind the name of their owner.
    """
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    fields = {
        id(statement.target)
        for owner in classes
        for statement in owner.body
        if isinstance(statement, ast.AnnAssign)
    }
    for node in ast.walk(tree):
        if id(node) in fields:
            continue
        match node:
            case ast.Name(id=name, ctx=ast.Store()) if name in VAGUE_NAMES:
                yield f"{node.lineno} {name}"
            case ast.arg(arg=name) | ast.FunctionDef(name=name) if name in VAGUE_NAMES:
                yield f"{node.lineno} {name}"
            case ast.ExceptHandler(name=str(name)) | ast.MatchAs(name=str(name)) | ast.MatchStar(name=str(name)):
                if name in VAGUE_NAMES:
                    yield f"{node.lineno} {name}"


def private_names(tree: ast.Module) -> Iterator[str]:
    """List functions and constants named by a private word."""
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) if PRIVATE_WORDS.search(name):
                yield f"{node.lineno} {name}"
            case ast.Assign(targets=[ast.Name(id=name)]) if name.isupper() and PRIVATE_WORDS.search(name):
                yield f"{node.lineno} {name}"


def pit_names(tree: ast.Module) -> Iterator[str]:
    """List names that call a defect a pit."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name) | ast.arg(arg=name) | ast.Attribute(attr=name) | ast.FunctionDef(name=name):
                if re.search(r"(?i)(?<![a-z])pits?(?![a-z])", name):
                    yield f"{node.lineno} {name}"


def faults(package: str, faults_in: Callable[[ast.Module], Iterator[str]]) -> list[str]:
    """Return the faults of a package, with file and line."""
    return [
        f"{path.relative_to(ROOT)}:{fault}"
        for path in source_files(package)
        for fault in faults_in(ast.parse(path.read_text(encoding="utf-8")))
    ]


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_of_functions_begin_with_a_verb(package: str) -> None:
    assert source_files(package)
    assert faults(package, odd_openings) == []


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_of_modules_classes_and_constants_begin_with_a_noun(package: str) -> None:
    assert faults(package, clauses) == []


@pytest.mark.parametrize("package", PACKAGES)
def test_names_describe_their_content(package: str) -> None:
    assert faults(package, vague_names) == []


@pytest.mark.parametrize("package", PACKAGES)
def test_functions_and_constants_have_words_of_the_field(package: str) -> None:
    assert faults(package, private_names) == []


def test_private_names_are_recognised() -> None:
    source = "def healthy_twin(): pass\nLONGEST_PLACE = 1\ndef replaced(): pass\n"
    assert list(private_names(ast.parse(source))) == ["1 healthy_twin", "2 LONGEST_PLACE"]


@pytest.mark.parametrize("package", PACKAGES)
def test_a_defect_is_called_defect(package: str) -> None:
    assert source_files(package)
    assert [
        path for path in source_files(package) if re.search(r"(?<![A-Za-z])[Pp]its?(?![A-Za-z])", path.stem)
    ] == []
    assert faults(package, pit_names) == []


def test_pits_are_recognised() -> None:
    assert list(pit_names(ast.parse("split = pitch = one_pit = PITS = x.pit"))) == ["1 one_pit", "1 PITS", "1 pit"]


def test_openings_that_are_no_imperative_are_recognised() -> None:
    sentences = [
        "What all rollers share.",
        "The step.",
        "Computes the step.",
        "x and y.",
        "One that opens.",
        "``a``.",
    ]
    assert [sentence for sentence in sentences if is_imperative(sentence)] == []
    assert all(is_imperative(sentence) for sentence in ("Return the step.", "Compute it.", "Pass a value on."))


def test_clauses_are_recognised_in_all_docstrings() -> None:
    source = '''"""What it is."""
LIMIT = 1
"""Where it ends."""
class Step:
    """How it is taken."""
    size: float
    """Which size."""
    @property
    def is_long(self):
        """Whether it is long."""
    def half(self):
        """What a function does is checked elsewhere."""
'''
    assert len(list(clauses(ast.parse(source)))) == 5


def opening_clauses(tree: ast.Module) -> Iterator[str]:
    """List modules, classes and functions whose docstring begins with a clause."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            text = ast.get_docstring(node)
            if text and text.split()[0].rstrip(",.:;") in NO_NOUNS:
                yield f"{getattr(node, 'lineno', 1)} {text.splitlines()[0]}"


def test_opening_clauses_are_recognised() -> None:
    source = '"""What it is."""\ndef size():\n    """How big it is."""\ndef half():\n    """Return a half."""\n'
    assert list(opening_clauses(ast.parse(source))) == ["1 What it is.", "2 How big it is."]


def test_docstrings_of_tests_and_benchmarks_begin_with_no_clause() -> None:
    paths = [path for folder in ("tests", "benchmarks") for path in sorted((ROOT / folder).rglob("*.py"))]
    assert len(paths) > 300
    assert [
        f"{path.relative_to(ROOT)}:{clause}"
        for path in paths
        for clause in opening_clauses(ast.parse(path.read_text(encoding="utf-8")))
    ] == []
