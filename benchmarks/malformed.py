"""Named study files that are broken, invalid or malicious."""

import gzip
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random

BASE = """\
study: hostile
bearing: nf308
speed: 1800 rpm
load: 150 N
duration: 0.1 s
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}
"""


def study_with(line: str) -> str:
    """Return the base study with a line added, replacing the line with the same key."""
    key = line.partition(":")[0]
    lines = [line_old for line_old in BASE.splitlines() if not line_old.startswith(f"{key}:")]
    return "\n".join([*lines, line]) + "\n"


def bomb(levels: int = 9, aliases: int = 10) -> str:
    """Return entries of a flow list whose aliases expand to ``aliases ** levels`` values."""
    lists = [f"&b{n} [{', '.join([f'*b{n - 1}'] * aliases)}]" for n in range(1, levels)]
    return ", ".join([f"&b0 [{', '.join(['q'] * aliases)}]", *lists])


def bombs() -> Iterator[tuple[str, str]]:
    """Yield studies with alias bombs in all blocks."""
    templates = {
        "load": "load: [{}]",
        "defects": "defects: [{}]",
        "key": "? [{}]\n: 1",
        "record": "record: [{}]",
        "study": "study: [{}]",
        "swept value": "sweep: {{load: [{}]}}",
        "swept path": "sweep:\n  ? [{}]\n  : [1 N]",
        "figures": "figures: [{}]",
        "quick": "quick: {{load: [{}]}}",
        "uncertainty": "uncertainty: {{damping: [{}]}}",
        "accuracy": "accuracy: [{}]",
        "bearing": "bearing: {{rollers: [{}]}}",
        "contact": "contact: {{damping: [{}]}}",
    }
    for block, template in templates.items():
        yield f"bomb in {block}", study_with(template.format(bomb()))
    yield "bomb of one long text", study_with(f"load: [&a {'q' * 900}, {', '.join(['*a'] * 900)}]")
    yield "bomb of mappings", study_with("load: {a: &a {x: 1, y: 2}, b: &b {x: *a, y: *a}, c: &c {x: *b, y: *b}}")
    yield "an alias in itself", study_with("load: &a [*a]")
    yield "an alias of nothing", study_with("load: *a")
    yield "merge keys", "base: &b {load: 150 N}\n" + study_with("<<: *b")
    yield "merge keys in a defect", study_with("defect: {<<: {shape: rectangular}, width: 1 mm}")


def nested() -> Iterator[tuple[str, str]]:
    """Yield studies with deep nesting."""
    for count in (21, 400, 3000):
        yield f"{count} lists", study_with(f"load: {'[' * count}{']' * count}")
        yield f"{count} mappings", study_with(f"load: {'{a: ' * count}1{'}' * count}")
    yield "3000 lists that do not end", study_with(f"load: {'[' * 3000}")
    yield "400 mappings in a sweep", study_with(f"sweep: {'{a: ' * 400}1{'}' * 400}")
    yield "blocks", "\n".join(f"{' ' * n}a:" for n in range(300)) + "\n"
    yield "dashes", study_with(f"load:\n  {'- ' * 400}1")
    yield "questions", study_with(f"load:\n  {'? ' * 400}1")


def numbers() -> Iterator[tuple[str, str]]:
    """Yield studies with numbers that are no valid floats or no plausible values."""
    nines = "9" * 5000
    for text in (
        "nan N", "inf N", "-inf N", ".inf", "1e400 N", "-1e400 N", "1e-400 N", "1e99999999999 N", f"{nines} N",
        f"0.{nines} N", f"1e{nines} N", f"-{nines}", "0x1F N", "0o17 N", "1_000 N", "1,5 N", "2026-07-01",
        "12:30:45", "~", "null", "yes", "150", "150 mm", "N", "150 N N", "- N", "--150 N", "\uff11\uff15\uff10 N",
        "\u0661 N",
        "1e308 kN", "150 N # \u202e", "!!float 150", "!!python/object/apply:os.system [ls]", "!mine 150 N",
    ):  # fmt: skip
        yield f"load {text[:30]}", study_with(f"load: {text}")
    yield "a count of 5000 digits", study_with(f"sweep: {{load: {{linspace: [1 N, 2 N, {nines}]}}}}")
    yield "ends of 5000 digits", study_with(f"sweep: {{load: {{linspace: [1 kN, 0.{nines} N, 5]}}}}")
    yield "a range without end", study_with("sweep: {load: {range: [1 N, 1e300 N, 1e-300 N]}}")
    yield "a range of no step", study_with("sweep: {load: {range: [1 N, 2 N, 0 N]}}")
    yield (
        "a million million cases",
        study_with("sweep: {load: {linspace: [1 N, 2 N, 99999]}, speed: {linspace: [1 rpm, 2 rpm, 99999]}}"),
    )
    yield "logspace from nothing", study_with("sweep: {load: {logspace: [0 N, 2 N, 5]}}")
    yield "a defect of 5000 digits", study_with(f"sweep: {{defects.{nines}.width: [1 mm]}}")
    yield "rollers of 5000 digits", study_with(f"seed: {nines}")
    yield "a speed that bursts", study_with("speed: 1e9 rpm")
    yield "a record without end", study_with("duration: 1e9 s")
    yield "a base that is replaced", study_with("load: 150 mm") + "sweep: {load: [1 N, 2 N]}\n"
    yield "a width that is replaced", study_with("sweep: {defect.width: [1 mm]}").replace("0.8 mm", "0.8 N")


def formulas() -> Iterator[tuple[str, str]]:
    """Yield studies with invalid formulas and with designs too large to compute."""
    for text in (
        "__import__('os').system('true') > 1", "().__class__.__bases__[0] > 1", "load.__class__ > 1",
        "10**10**10 > 1", "[x for x in (1,)] == 1", "(lambda: 1)() > 0", "open('/etc/passwd') == 1",
        "load > load[0]", f"{'(' * 390}", f"{'-' * 390}1 > 0", f"{'9' * 5000} > 1", f"{'+'.join('1' * 190)} > 0",
        "load / 0 > 1 N", "1 if load else 2", "f'{load}' == 1", "load > 1 mm", "lod > 1 N", "\\0 > 1",
        "9**9**9**9 * load > 1 N", "not " * 90 + "load",
    ):  # fmt: skip
        yield f"where {text[:30]}", study_with(f'sweep: {{where: ["{text}"]}}')
    cycle = ", ".join(
        f"defect.{a}: defect.{b}" for a, b in (("width", "depth"), ("depth", "length"), ("length", "width"))
    )
    yield "derived in a circle", study_with(f"sweep: {{derived: {{{cycle}}}}}")
    yield "5000 derived", BASE + "sweep:\n  derived:\n" + "".join(f"    x{n}: 1\n" for n in range(5000))
    yield "5000 conditions", study_with(f"sweep: {{where: [{', '.join(['1 > 0'] * 5000)}]}}")
    for kind in ("lhs", "sobol", "saltelli", "morris"):
        for n in ("1000000000", "9" * 5000, "-1", "1e9", "[1]"):
            yield (
                f"{kind} of {n[:10]} points",
                study_with(f"sweep: {{{kind}: {{n: {n}, over: {{load: [1 N, 2 N]}}}}}}"),
            )
        yield f"{kind} of nothing", study_with(f"sweep: {{{kind}: {{n: 8, over: {{}}}}}}")
    yield (
        "a seed of 5000 digits",
        study_with(f"sweep: {{lhs: {{n: 8, seed: {'9' * 5000}, over: {{load: [1 N, 2 N]}}}}}}"),
    )
    yield "a billion repeats", study_with("sweep: {repeat: 1000000000}")


def encoded() -> Iterator[tuple[str, bytes]]:
    """Yield studies with invalid characters or encodings."""
    text = BASE.encode()
    for name, escape in (("surrogate", "\\ud800"), ("NUL", "\\0"), ("escape", "\\e[31m"), ("bell", "\\a")):
        yield f"a {name} in a name", study_with(f'bearing: "{escape}"').encode()
        yield f"a {name} in a key", study_with(f'"{escape}": 1').encode()
    yield "a surrogate in a title", study_with('figures: [{x: load, y: velocity.rms, title: "\\ud800"}]').encode()
    for byte in (0, 1, 7, 8, 11, 12, 27, 31, 127):
        yield f"the byte {byte}", text + bytes([byte])
    for encoding in ("utf-16", "utf-16-be", "utf-32", "cp037"):
        yield encoding, BASE.encode(encoding)
    yield "latin-1", text + "x: \u00e9\n".encode("latin-1")
    yield "a surrogate in UTF-8", text + b"x: \xed\xa0\x80\n"
    yield "an overlong letter", text + b"x: \xc0\xaf\n"
    yield "half a letter", text + b"x: \xe2\x82"
    yield "random bytes", Random(0).randbytes(5000)
    yield "an archive", gzip.compress(text)
    yield "HDF5", b"\x89HDF\r\n\x1a\n" + bytes(2000)
    yield "zeros", bytes(100_000)
    yield "one long line", b"study: " + b"a" * 90_000
    yield "too long", text + b"# comment\n" * 40_000
    yield "ten megabytes", b"- a\n" * 2_500_000
    yield "empty", b""
    yield "a mark and nothing", b"\xef\xbb\xbf"
    yield "blanks", b" \n \n"
    yield "comments", b"# a\n# b\n"


def other_documents() -> Iterator[tuple[str, str]]:
    """Yield YAML files that are not studies."""
    yield "two documents", BASE + "---\n" + BASE
    yield "a document's end", BASE + "...\nx\n"
    yield "a directive", "%YAML 9.9\n---\n" + BASE
    yield "a list", "- a\n- b\n"
    yield "a text", "hello\n"
    yield "a key twice", BASE + "load: 200 N\n"
    yield "a key by both words", BASE + "prove: true\nstep_check: true\n"
    yield "tabs", BASE.replace("load: ", "load:\t\n\t")
    yield "a quote that stays open", study_with('bearing: "nf308')
    yield "a list that stays open", study_with("record: [ring.velocity")
    yield "no blank after a colon", BASE.replace(": ", ":")
    yield "a value below a value", study_with("load: 150 N\n  more: 1")
    yield "JSON cut short", '{"study": "a", "load": "150'
    yield "5000 unknown keys", BASE + "".join(f"x{n}: 1\n" for n in range(5000))
    yield "5000 unknown paths", BASE + "sweep:\n" + "".join(f"  x{n}: [1]\n" for n in range(5000))
    yield "5000 unknown channels", study_with(f"record: [{', '.join(f'x{n}' for n in range(5000))}]")
    yield (
        "5000 unknown features",
        study_with(f"figures: [{{x: load, y: [{', '.join(f'x{n}' for n in range(5000))}]}}]"),
    )
    defect = "{shape: rectangular, length: 1 mm, width: 1 mm, depth: 1 um}"
    yield "1000 defects", BASE.replace("defect:", "#") + f"defects: [{', '.join([defect] * 1000)}]\n"
    yield (
        "5000 wrong cases",
        study_with("load: 150 mm") + "sweep: {defect.width: {linspace: [1 mm, 2 mm, 5000]}}\n",
    )
    for key in SECTIONS:
        for value in ("[]", "{}", "''", "[[]]", "{a: {b: [c]}}"):
            if (key, value) not in EMPTY_SECTIONS:
                yield f"{key} is {value}", study_with(f"{key}: {value}")
    for path in (
        "/dev/zero",
        "/",
        "../../../../etc/passwd",
        "a" * 5000,
        "nf308.yaml",
        "~/nf308.yaml",
        "a\\0.yaml",
    ):
        yield f"a bearing in {path[:30]}", study_with(f'bearing: "{path}"')
        yield f"a scan in {path[:30]}", study_with(f'defect: {{shape: scan, file: "{path}"}}')


SECTIONS = ("bearing", "rig", "contact", "defect", "defects", "record", "sweep", "figures", "quick", "uncertainty")
EMPTY_SECTIONS = {("rig", "{}"), ("contact", "{}"), ("defects", "[]"), ("record", "[]"), ("sweep", "{}")}
EMPTY_SECTIONS |= {("figures", "[]"), ("quick", "{}"), ("uncertainty", "{}")}
"""Empty sections, which are valid and have no effect."""


def malformed(folder: Path) -> Iterator[tuple[str, Path]]:
    """Write all malformed files into a folder; yield names and paths."""
    texts = [*bombs(), *nested(), *numbers(), *formulas(), *other_documents()]
    contents = [(name, text.encode("utf-8", "surrogatepass")) for name, text in texts] + list(encoded())
    for number, (name, content) in enumerate(contents):
        path = folder / f"malformed-{number}.yaml"
        path.write_bytes(content)
        yield name, path
    yield "a folder", folder
    yield "no file", folder / "none.yaml"
    yield "a device", Path("/dev/zero")
    yield "a name that is too long", folder / f"{'a' * 300}.yaml"
    for name, make in SPECIAL_FILES.items():
        path = folder / f"{name.replace(' ', '-')}.yaml"
        make(path)
        yield name, path


SPECIAL_FILES: dict[str, Callable[[Path], object]] = {
    "a pipe": os.mkfifo,
    "a loop of links": lambda path: path.symlink_to(path),
    "a link to nothing": lambda path: path.symlink_to(path.with_name("nothing")),
    "a link to a device": lambda path: path.symlink_to("/dev/zero"),
}
