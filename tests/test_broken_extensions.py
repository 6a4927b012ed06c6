"""An extension that does not load is left out, whatever it does; what computes refuses to go on without it."""

import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from bearingsim import catalogue, extensions
from bearingsim.catalogue import Feature, Law, Model, register
from bearingsim.config import names
from bearingsim.config.sections.laws import laws_of
from bearingsim.errors import UserError
from bearingsim.runner.delivery import installation
from bearingsim.simulation import simulate
from bearingsim.study import load_study
from tests.scenes.short_cases import case

BROKEN = {
    "a module that is not there": ("", "ModuleNotFoundError: No module named 'nowhere'"),
    "a dependency that is not there": ("import nothing_of_that_name", "No module named 'nothing_of_that_name'"),
    "no Python": ("x = (", "SyntaxError: '(' was never closed (flawed.py, line 1)"),
    "an end of the process": ("raise SystemExit(3)", "SystemExit: 3"),
    "an error": ("1 / 0", "ZeroDivisionError: division by zero"),
    "an error of several lines": ("raise ValueError('first\\nsecond')", "ValueError: first"),
    "no entry": ("from bearingsim.catalogue import register\nregister(3)", "ValueError: expected a Model,"),
    "a name that is taken": (
        "from bearingsim.catalogue import Method, register\nregister(Method('verlet', 'flawed'))",
        "ValueError: `verlet` is already registered",
    ),
    "no such object": ("", "AttributeError: module 'flawed' has no attribute 'thing'"),
}
VALUES = {"a module that is not there": "nowhere", "no such object": "flawed:thing"}


@pytest.fixture(autouse=True)
def no_extensions(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A folder for modules, none of which is imported yet; none is broken."""
    monkeypatch.syspath_prepend(tmp_path)
    for module in ("flawed", "laws", "features"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    monkeypatch.setattr(extensions, "BROKEN", {})
    return tmp_path


def install(monkeypatch: pytest.MonkeyPatch, value: str) -> None:
    """Name a module in an entry point called `mine`."""
    entry = EntryPoint("mine", value, extensions.GROUP)
    monkeypatch.setattr(extensions, "enabled", lambda: (entry,))


@pytest.mark.parametrize("kind", BROKEN)
def test_broken_extension_is_skipped(kind, no_extensions, monkeypatch) -> None:
    text, error = BROKEN[kind]
    value = VALUES.get(kind, "flawed")
    (no_extensions / "flawed.py").write_text(text)
    install(monkeypatch, value)
    extensions.load()
    sentence = extensions.BROKEN["mine"]
    assert sentence.startswith(f"the extension `mine` ({value}) does not load: ")
    assert error in sentence
    assert "\n" not in sentence


def test_an_interrupt_is_no_fault_of_an_extension(no_extensions, monkeypatch) -> None:
    (no_extensions / "flawed.py").write_text("raise KeyboardInterrupt")
    install(monkeypatch, "flawed")
    with pytest.raises(KeyboardInterrupt):
        extensions.load()


SECTIONS = {
    "x = (": "does not load (SyntaxError: '(' was never closed (laws.py, line 1))",
    "": "does not load (AttributeError: module 'laws' has no attribute 'Section')",
    "Section = 3": "is of type int, not type",
    "class Section: pass": "is not a subclass of bearingsim.config.fields.Section",
}


@pytest.mark.parametrize("text", SECTIONS)
def test_a_law_whose_section_does_not_load_is_left_out(text, no_extensions, monkeypatch) -> None:
    (no_extensions / "laws.py").write_text(text)
    install(monkeypatch, "laws")
    monkeypatch.setitem(catalogue.LAWS["damping"], "mine", Law("mine", "damping", "laws:Section", "laws:build"))
    assert "mine" not in laws_of("damping", "kraemer").sections
    assert {"mine": f"`laws:Section` of the extension `mine` {SECTIONS[text]}"} == extensions.BROKEN


@pytest.mark.parametrize(
    ("name", "objection"),
    [
        ("velocity.rms", "which already exists"),
        ("acceleration.rms@2000-5000Hz", "which already exists"),
        ("status", "which is a column of the results table"),
        ("job", "which is a column of the results table"),
        ("error.model", "which is a column of the results table"),
        ("knock.phase", "whose ending belongs to spectral lines"),
        ("knock-healthy", "whose ending belongs to spectral lines"),
    ],
)
def test_a_feature_with_a_name_of_the_program_is_left_out(name, objection, monkeypatch) -> None:
    install(monkeypatch, "features")
    monkeypatch.setitem(catalogue.FEATURES, name, Feature(name, "", "another", "features:rms"))
    assert name not in names._extension_features(names._BUILTIN_FEATURES)
    assert {
        "mine": f"the extension `mine` registers the feature `{name}`, {objection}: rename it"
    } == extensions.BROKEN


@pytest.mark.parametrize(
    "settings", ["sweep: {load: [150 N, 300 N]}", "sweep: {speed: [900 rpm], derived: {load: 150 N}}"]
)
def test_a_swept_path_with_the_name_of_a_feature_is_refused(settings, write, monkeypatch) -> None:
    """Otherwise the column of the loads would contain the feature."""
    install(monkeypatch, "features")
    monkeypatch.setitem(catalogue.FEATURES, "load", Feature("load", "N", "largest load", "features:load"))
    study = write(f"study: own\nbearing: nf308\nspeed: 1800 rpm\nload: 150 N\n{settings}\n")
    with pytest.raises(
        UserError, match=r":\d+:\d+: `load` is also a feature of the extension `mine` \(rename the feature\)"
    ):
        load_study(study)


def test_no_job_is_computed_without_a_broken_extension(write, monkeypatch) -> None:
    """Neither by this process nor by a worker; other skipped extensions remain skipped."""
    monkeypatch.setenv(extensions.SKIP, "other")
    install(monkeypatch, "flawed")
    extensions.record_failure("mine", "it is broken")
    extensions.record_failure("mine", "in two ways")
    advice = "Fix the extension, or set BEARINGSIM_SKIP_EXTENSIONS=mine,other to run without the extension"
    message = f"^it is broken\n{advice}$"
    with pytest.raises(extensions.BrokenExtension, match=message):
        load_study(write("study: own\n"))
    with pytest.raises(extensions.BrokenExtension, match=message):
        installation.__wrapped__()
    with pytest.raises(extensions.BrokenExtension, match=message):
        simulate(case(model="static"))


def test_code_of_another_package_cannot_be_skipped(monkeypatch) -> None:
    """The name of a package is no entry point, so the variable would have no effect."""
    install(monkeypatch, "flawed")
    assert extensions.owner("features:rms") == "features"
    extensions.record_failure("mine", "a")
    extensions.record_failure("features", "b")
    with pytest.raises(extensions.BrokenExtension, match=r"^a\nb\nFix or uninstall the extensions\.$"):
        extensions.raise_if_broken()


def test_owner_is_the_entry_point_nearest_to_the_code(monkeypatch) -> None:
    entries = tuple(EntryPoint(name, f"flawed.{name}", extensions.GROUP) for name in ("laws", "models"))
    monkeypatch.setattr(extensions, "enabled", lambda: entries)
    owners = [extensions.owner(reference) for reference in ("flawed.models.ring:Ring", "flawed.laws", "flawed:A")]
    assert owners == ["models", "laws", "laws"]


def test_skipped_extensions_are_not_enabled(monkeypatch) -> None:
    entries = [EntryPoint(name, name, extensions.GROUP) for name in ("b", "a", "c")]
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: entries)
    monkeypatch.setenv(extensions.SKIP, " b , d,")
    assert [entry.name for entry in extensions.enabled.__wrapped__()] == ["a", "c"]


CODE = {
    "flawed.part:KIND": "^`flawed.part:KIND` of the extension `mine` does not load .ModuleNotFoundError",
    "flawed:KIND": "^`flawed:KIND` of the extension `mine` is of type int, not dict$",
    "bearingsim.errors:KIND": "^`bearingsim.errors:KIND` does not load .AttributeError",
}


@pytest.mark.parametrize("place", CODE)
def test_code_that_does_not_load_is_named(place, no_extensions, monkeypatch) -> None:
    (no_extensions / "flawed.py").write_text("KIND = 3\n")
    install(monkeypatch, "flawed")
    with pytest.raises(UserError, match=CODE[place]):
        catalogue.code(place, dict)


def test_a_function_that_fails_is_named(no_extensions, monkeypatch) -> None:
    """One of the program's own fails as it fails."""
    (no_extensions / "flawed.py").write_text("def build(case):\n    raise SystemExit(case)\n")
    install(monkeypatch, "flawed")
    message = "^`flawed:build` of the extension `mine` fails .SystemExit: 4.$"
    with pytest.raises(extensions.BrokenExtension, match=message):
        catalogue.call("flawed:build", 4)
    with pytest.raises(TypeError):
        catalogue.call("bearingsim.errors:Refused")


def test_sources_are_those_of_all_code_that_is_registered(no_extensions, monkeypatch) -> None:
    """Of packages beside that of the entry point, too; what is no file, as an editor's lock, is left out."""
    install(monkeypatch, "flawed")
    (no_extensions / "flawed.py").write_text("")
    package = no_extensions / "features"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / ".#__init__.py").symlink_to("me@nowhere.1234")
    monkeypatch.setitem(catalogue.FEATURES, "mine", Feature("mine", "", "mine", "features.rms:rms"))
    sources = list(catalogue.extension_sources())
    assert sources == [package / "__init__.py", no_extensions / "flawed.py"]


def test_only_entries_are_registered(monkeypatch) -> None:
    monkeypatch.setattr(catalogue, "MODELS", {})
    with pytest.raises(ValueError, match="got `3`"):
        register(Model("mine", "flawed", frozenset()), 3)  # type: ignore[arg-type]
