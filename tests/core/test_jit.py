"""Compilation, its cache, and dispatch of generic functions."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numba
import pytest
from numba.core.codegen import get_host_cpu_features

from bearingsim.core import advance as driver
from bearingsim.core import jit
from bearingsim.core.laws.damping.general import make_general
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.damping.kraemer import Kraemer
from bearingsim.core.laws.stiffness.power_laws import TenNinths

VARIATIONS = """
import bearingsim.core.sampling, importlib, pkgutil, bearingsim.core as core
from bearingsim.config import Case
from bearingsim.simulation import compile_solvers, simulate

def compiled():
    modules = [importlib.import_module(m.name) for m in pkgutil.walk_packages(core.__path__, "bearingsim.core.")]
    found = {f for m in modules for f in vars(m).values() if hasattr(f, "signatures") and hasattr(f, "py_func")}
    return {f"{f.py_func.__module__}.{f.py_func.__name__}": len(f.signatures) for f in found}

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
BASE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "duration": "13 ms", "settle": "0 s"}
CASES = [Case.model_validate(BASE | {"model": "ring"} | more) for more in (
    {},
    {"defect": SLOT},
    {"defect": SLOT | {"shape": "circular", "length": 0.003}, "contact": {"length_nodes": 3}},
    {"defects": [SLOT, SLOT | {"shape": "triangular", "angle": 1}, SLOT | {"angle": "-1 rad"}]},
    {"defect": SLOT, "start_angle": 0},
    {"defects": [SLOT | {"race": "inner"}, SLOT | {"race": "roller", "roller": 3, "angle": 1}, SLOT]},
    {"load": 200, "speed": 100, "clearance": 0, "start_angle": 0, "duration": 1, "sampling": 1000, "settle": 0},
    {"contact": {"stiffness": "iso16281", "damping": {"beta": 1e-5}}},
    {"record": ["roller.outer_force"], "sampling": 50e3},
    {"sampling": 300e3, "step": "1 us"},
    {"rig": {"name": "x", "ring_mass": 1, "bracket_stiffness": 10000000, "bracket_damping": 0}},
    {"antialias": "false"},
    {"antialias": "false", "duration": "0.1 s", "settle": "20 ms"},
)]
compile_solvers(CASES)
before = compiled()
assert before["bearingsim.core.advance.advance_and_sample"] == 1, before
for case in CASES:
    simulate(case)
    assert compiled() == before, (case, {k: v for k, v in compiled().items() if v != before.get(k)})
print(len(before))
"""


def test_input_values_cause_no_recompilation() -> None:
    """After ``compile_solvers``, other numbers, defects, shapes and filters compile no further signature."""
    run = subprocess.run([sys.executable, "-c", VARIATIONS], capture_output=True, text=True, timeout=80)
    assert run.returncode == 0, run.stderr[-2000:]
    assert int(run.stdout) > 20


# Cache of compiled code


@pytest.fixture
def core_copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    core = tmp_path / "core"
    shutil.copytree(jit.CORE, core, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(jit, "CORE", core)
    return core


@pytest.mark.parametrize("source", ["laws/damping/kraemer.py", "models/ring.py", "__init__.py"])
def test_a_changed_source_gets_another_folder(
    core_copy: Path, source: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("BEARINGSIM_CACHE", str(tmp_path / "cache"))
    before = jit.code_folder()
    assert before.is_dir()
    assert before.parent.parent == tmp_path / "cache"
    assert jit.code_folder() == before
    (core_copy / source).write_text((core_copy / source).read_text() + "\n")
    assert jit.code_folder() != before
    assert jit.source_digest() in str(jit.code_folder())


def test_digest_does_not_depend_on_the_folder(core_copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    digest = jit.source_digest()
    monkeypatch.undo()
    assert jit.source_digest() == digest


def test_another_numba_gets_another_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    before = jit.source_digest()
    monkeypatch.setattr(numba, "__version__", "0.0")
    assert jit.source_digest() != before


def test_a_cache_that_cannot_be_made_falls_back_to_the_temporary_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("BEARINGSIM_CACHE", str(tmp_path / "file"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    folder = jit.code_folder()
    assert folder.is_dir()
    assert folder.parents[1].name == f"bearingsim-{os.getuid()}"
    assert folder == jit.code_folder()  # as in a child process
    (line,) = capsys.readouterr().err.splitlines()
    assert line == (
        f"bearingsim: compiled code is cached in {folder.parent}: {tmp_path}/file/bearingsim: Not a directory"
    )


def test_missing_home_folder_uses_the_temporary_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def raise_error() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("BEARINGSIM_CACHE", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", raise_error)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert tmp_path in jit.code_folder().parents
    assert capsys.readouterr().err.endswith(": there is no home folder\n")


def test_a_cache_that_cannot_be_written_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BEARINGSIM_CACHE", str(tmp_path / "locked"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "free"))
    monkeypatch.setattr(os, "access", lambda folder, mode: "locked" not in str(folder))
    assert tmp_path / "free" in jit.code_folder().parents


def test_compiled_code_goes_only_into_the_cache_folder() -> None:
    assert Path(driver.advance_and_sample._cache.cache_path).is_relative_to(str(jit._CACHE))
    assert str(jit.numba_config.CACHE_DIR) == os.environ.get("NUMBA_CACHE_DIR", "")


def test_compiled_code_is_saved_by_one_process_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    lock = mock.MagicMock()
    monkeypatch.setattr(jit, "saving_lock", lambda process: lock)
    compiled_half = jit.jit(half)
    compiled_half._cache._save_overload = lambda *arguments: lock.saved(
        lock.__enter__.call_count, lock.__exit__.call_count
    )
    assert compiled_half(3.0) == 1.5
    lock.saved.assert_called_once_with(1, 0)


COMPILE_AFTER_START = """
import sys, time
from pathlib import Path
from bearingsim.core import jit
from bearingsim.core.laws.stiffness.power_laws import ninth_root
folder = Path(sys.argv[2])
(folder / sys.argv[1]).touch()
while not ((folder / "one").exists() and (folder / "other").exists()):
    time.sleep(1e-3)
compiled = []
with jit.compilation_callbacks(lambda: compiled.append(True), lambda: None):
    ninth_root(2.0)
print(len(compiled))
"""


def test_two_processes_compile_a_function_once(tmp_path: Path) -> None:
    environment, cache = os.environ | {"BEARINGSIM_CACHE": str(tmp_path / "cache")}, tmp_path / "cache"
    cache.mkdir()
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", COMPILE_AFTER_START, name, str(tmp_path)],
            env=environment,
            stdout=subprocess.PIPE,
        )
        for name in ("one", "other")
    ]
    assert sorted(int(process.communicate()[0]) for process in processes) == [0, 1]


def test_unreadable_cache_entries_are_recompiled() -> None:
    def raise_error(*arguments: Any) -> None:
        raise ModuleNotFoundError("No module named 'elsewhere'")

    dispatcher: Any = numba.njit(cache=True)(half)
    dispatcher._cache._load_overload = dispatcher._cache._save_overload = raise_error
    assert jit.guard_cache(dispatcher)(3.0) == 1.5


def half(x: float) -> float:
    return 0.5 * x


# One name, one implementation per type


class Double(NamedTuple):
    """Rule that doubles a number."""

    unit: float


class Sum(NamedTuple):
    """Rule that adds to a number."""

    unit: float
    more: float


@jit.generic
def apply_rule(rule: Any, x: float) -> float:
    """Apply a rule to a number."""


@apply_rule.register(Double)
def _twice(rule: Double, x: float) -> float:
    return 2.0 * x * rule.unit


@apply_rule.register(Sum)
def _plus(rule: Sum, x: float) -> float:
    return x + rule.more * rule.unit


@numba.njit
def compiled_rule(rule: Any, x: float) -> float:
    return apply_rule(rule, x)


@pytest.mark.parametrize(("rule", "expected"), [(Double(3.0), 12.0), (Sum(3.0, 0.5), 3.5)])
def test_dispatch_from_python_equals_the_compiled_one(rule: Any, expected: float) -> None:
    assert apply_rule(rule, 2.0) == expected
    assert compiled_rule(rule, 2.0) == expected


def test_generic_keeps_name_and_docstring_and_lists_its_types() -> None:
    assert apply_rule.__name__ == "apply_rule"
    assert apply_rule.__doc__ == "Apply a rule to a number."
    assert set(apply_rule.types) == {Double, Sum}


def test_type_without_implementation_is_rejected_by_python_and_compiler() -> None:
    class Other(NamedTuple):
        unit: float

    with pytest.raises(
        TypeError, match=r"`apply_rule` is not registered for Other: @apply_rule.register\(Other\)"
    ):
        apply_rule(Other(1.0), 2.0)
    with pytest.raises(numba.TypingError, match="`apply_rule` is not registered for Other"):
        compiled_rule(Other(1.0), 2.0)


# Absent types


@jit.absent
class Absent(NamedTuple):
    """Absent rule."""


@jit.absent
class AbsentWithValue(NamedTuple):
    """Absent rule with its own implementation of ``value``."""


class Undeclared(NamedTuple):
    """Empty type that is not declared absent."""


@jit.generic(absent=0.5)
def value(rule: Any, x: float) -> float:
    """Return a number."""


@value.register(AbsentWithValue)
def _value_of_silence(rule: AbsentWithValue, x: float) -> float:
    return 10.0 * x


@jit.generic(absent=(1.0, 2.0))
def pair(rule: Any, x: float) -> tuple[float, float]:
    """Return two numbers."""


@jit.generic(absent=lambda rule, x: -x)
def negated(rule: Any, x: float) -> float:
    """Return a number from the default's function."""


@jit.generic(absent=None)
def fill(rule: Any, x: float) -> None:
    """Return nothing."""


@jit.generic
def required(rule: Any, x: float) -> float:
    """Return a number; without a default for absent types."""


@jit.generic(absent=0.0, otherwise=lambda rule, x: 3.0 * x)
def tripled(rule: Any, x: float) -> float:
    """Return a number, with a default for all types."""


@numba.njit
def all_values(rule: Any, x: float) -> Any:
    return value(rule, x), pair(rule, x), negated(rule, x), fill(rule, x), tripled(rule, x)


def test_absent_types_use_the_default() -> None:
    for run in (all_values, all_values.py_func):
        assert run(Absent(), 2.0) == (0.5, (1.0, 2.0), -2.0, None, 0.0)
        assert run(AbsentWithValue(), 2.0) == (20.0, (1.0, 2.0), -2.0, None, 0.0)


def test_otherwise_applies_to_unregistered_types() -> None:
    assert tripled(Undeclared(), 2.0) == compiled_tripled(Undeclared(), 2.0) == 6.0


@numba.njit
def compiled_tripled(rule: Any, x: float) -> float:
    return tripled(rule, x)


@pytest.mark.parametrize(("function", "rule"), [(value, Undeclared()), (required, Absent())])
def test_default_applies_only_to_absent_types(function: Any, rule: Any) -> None:
    @numba.njit
    def called(rule: Any, x: float) -> float:
        return function(rule, x)

    refusal = f"`{function.__name__}` is not registered for {type(rule).__name__}"
    with pytest.raises(TypeError, match=refusal):
        function(rule, 2.0)
    with pytest.raises(numba.TypingError, match=refusal):
        called(rule, 2.0)


UNCOMPILED = """
from bearingsim.core.laws.friction.curves import Frictionless
from bearingsim.core.laws.friction.interface import mu, mu_derivative
from bearingsim.core.methods.verlet import Verlet
assert mu(Frictionless(), 0.1, 1.0) == 0.0 and mu_derivative(Frictionless(), 0.1, 1.0) == (0.0, 0.0)
try:
    mu(Verlet(1.0), 0.1, 1.0)
except TypeError as error:
    print(error)
"""


def test_dispatch_works_without_the_compiler() -> None:
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    run = subprocess.run([sys.executable, "-c", UNCOMPILED], capture_output=True, text=True, env=environment)
    assert run.stdout == "`mu` is not registered for Verlet: @mu.register(Verlet)\n", run.stderr


@numba.njit
def force(law: Any, delta: float, v: float) -> float:
    return normal_force(law, delta, v)


@pytest.mark.parametrize(
    "law",
    [
        HuntCrossley(TenNinths(1e9), 50.0),
        Kraemer(TenNinths(1e9), 1e-5),
        make_general(TenNinths(1e9), 1e6, 1.5, 0.7),
    ],
    ids=lambda law: type(law).__name__,
)
@pytest.mark.parametrize("delta", [-1e-6, 0.0, 1e-7, 3e-6])
def test_contact_laws_from_python_equal_the_compiled_ones(law: Any, delta: float) -> None:
    for v in (-0.5, -0.01, 0.0, 0.01, 0.5):
        assert force(law, delta, v) == pytest.approx(normal_force(law, delta, v), rel=1e-13, abs=1e-15)


@pytest.mark.parametrize(
    ("features", "is_wide"), [("+avx2,+avx512vbmi2", True), ("+avx2,-avx512vbmi2", False), ("", False)]
)
def test_wide_vectors_are_preferred_only_where_the_processor_has_them(features: str, is_wide: bool) -> None:
    assert jit.with_wide_vectors(features) == features + ",-prefer-256-bit" * is_wide


@pytest.mark.parametrize("given", [None, "", "+sse2"])
def test_features_given_in_the_environment_are_used(given: str | None) -> None:
    name = "NUMBA_CPU_FEATURES"
    environment = {key: value for key, value in os.environ.items() if key != name}
    script = "from bearingsim.core.jit import numba_config; print(numba_config.CPU_FEATURES)"
    printed = subprocess.run(
        [sys.executable, "-c", script],
        env=environment | ({} if given is None else {name: given}),
        check=True,
        capture_output=True,
        text=True,
    ).stdout.strip()
    assert printed == (jit.with_wide_vectors(get_host_cpu_features()) if given is None else given)
