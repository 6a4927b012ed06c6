"""What is compiled, how often, and where it is kept."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numba
import numpy as np
import pytest

from bearingsim.core import advance as driver
from bearingsim.core import jit
from bearingsim.core.laws.damping.general import general
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.damping.kraemer import Kraemer
from bearingsim.core.laws.stiffness.power_laws import TenNinths

VARIATIONS = """
import bearingsim.core.sampling, importlib, pkgutil, bearingsim.core as core
from bearingsim.config import Case
from bearingsim.simulation import simulate, warm

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
warm(CASES)
before = compiled()
assert before["bearingsim.core.advance.advance_and_sample"] == 1, before
for case in CASES:
    simulate(case)
    assert compiled() == before, (case, {k: v for k, v in compiled().items() if v != before.get(k)})
print(len(before))
"""


def test_values_never_compile_anything_again() -> None:
    """Ints for floats, defects and shapes, raw or filtered: after ``warm`` everything is there, once."""
    run = subprocess.run([sys.executable, "-c", VARIATIONS], capture_output=True, text=True, timeout=80)
    assert run.returncode == 0, run.stderr[-2000:]
    assert int(run.stdout) > 20


# Where compiled code is kept


@pytest.fixture
def copied_core(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    core = tmp_path / "core"
    shutil.copytree(jit.CORE, core, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(jit, "CORE", core)
    return core


@pytest.mark.parametrize("source", ["laws/damping/kraemer.py", "models/ring.py", "__init__.py"])
def test_a_changed_source_gets_another_folder(
    copied_core: Path, source: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("BEARINGSIM_CACHE", str(tmp_path / "cache"))
    before = jit.cache_folder()
    assert before.is_dir()
    assert before.parent.parent == tmp_path / "cache"
    assert jit.cache_folder() == before
    (copied_core / source).write_text((copied_core / source).read_text() + "\n")
    assert jit.cache_folder() != before
    assert jit.source_digest() in str(jit.cache_folder())


def test_a_copy_elsewhere_is_the_same_source(copied_core: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    there = jit.source_digest()
    monkeypatch.undo()
    assert jit.source_digest() == there


def test_another_numba_gets_another_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    before = jit.source_digest()
    monkeypatch.setattr(numba, "__version__", "0.0")
    assert jit.source_digest() != before


def test_a_cache_that_cannot_be_made_falls_back_to_the_temporary_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("BEARINGSIM_CACHE", str(tmp_path / "file"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    found = jit.cache_folder()
    assert found.is_dir()
    assert found.parents[1].name == f"bearingsim-{os.getuid()}"


def test_no_home_is_no_reason_to_fail(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("BEARINGSIM_CACHE", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert tmp_path in jit.cache_folder().parents


def test_a_cache_that_cannot_be_written_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BEARINGSIM_CACHE", str(tmp_path / "locked"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "free"))
    monkeypatch.setattr(os, "access", lambda folder, mode: "locked" not in str(folder))
    assert tmp_path / "free" in jit.cache_folder().parents


def test_compiled_code_goes_into_that_folder_and_nowhere_else() -> None:
    assert Path(driver.advance._cache.cache_path).is_relative_to(str(jit._CACHE))
    assert str(jit.numba_config.CACHE_DIR) == os.environ.get("NUMBA_CACHE_DIR", "")


def test_compiled_code_is_saved_by_one_process_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    held = mock.MagicMock()
    monkeypatch.setattr(jit, "saving_lock", lambda process: held)
    halved = jit.jit(halve)
    halved._cache._save_overload = lambda *given: held.saved(held.__enter__.call_count, held.__exit__.call_count)
    assert halved(3.0) == 1.5
    held.saved.assert_called_once_with(1, 0)


TOGETHER = """
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
    here, cache = os.environ | {"BEARINGSIM_CACHE": str(tmp_path / "cache")}, tmp_path / "cache"
    cache.mkdir()
    both = [
        subprocess.Popen([sys.executable, "-c", TOGETHER, name, str(tmp_path)], env=here, stdout=subprocess.PIPE)
        for name in ("one", "other")
    ]
    assert sorted(int(process.communicate()[0]) for process in both) == [0, 1]


def test_what_others_have_saved_and_took_away_is_compiled_anew() -> None:
    def gone(*given: Any) -> None:
        raise ModuleNotFoundError("No module named 'elsewhere'")

    dispatcher: Any = numba.njit(cache=True)(halve)
    dispatcher._cache._load_overload = dispatcher._cache._save_overload = gone
    assert jit.guard_cache(dispatcher)(3.0) == 1.5


def halve(x: float) -> float:
    return 0.5 * x


# One name, one implementation per type


class Twice(NamedTuple):
    """Doubles."""

    unit: float


class Plus(NamedTuple):
    """Adds."""

    unit: float
    more: float


@jit.generic
def applied(rule: Any, x: float) -> float:
    """A rule applied to a number."""


@applied.register(Twice)
def _twice(rule: Twice, x: float) -> float:
    return 2.0 * x * rule.unit


@applied.register(Plus)
def _plus(rule: Plus, x: float) -> float:
    return x + rule.more * rule.unit


@numba.njit
def compiled(rule: Any, x: float) -> float:
    return applied(rule, x)


@pytest.mark.parametrize(("rule", "expected"), [(Twice(3.0), 12.0), (Plus(3.0, 0.5), 3.5)])
def test_dispatch_from_python_equals_the_compiled_one(rule: Any, expected: float) -> None:
    assert applied(rule, 2.0) == expected
    assert compiled(rule, 2.0) == expected


def test_generic_keeps_name_and_docstring_and_tells_its_types() -> None:
    assert applied.__name__ == "applied"
    assert applied.__doc__ == "A rule applied to a number."
    assert set(applied.types) == {Twice, Plus}


def test_a_type_without_implementation_is_refused_by_both() -> None:
    class Other(NamedTuple):
        unit: float

    with pytest.raises(TypeError, match=r"`applied` is not registered for Other: @applied.register\(Other\)"):
        applied(Other(1.0), 2.0)
    with pytest.raises(numba.TypingError, match="`applied` is not registered for Other"):
        compiled(Other(1.0), 2.0)


# Types that stand for nothing


@jit.absent
class Nothing(NamedTuple):
    """No rule."""


@jit.absent
class Silence(NamedTuple):
    """Nothing either, but for the value it has."""


class Forgotten(NamedTuple):
    """As empty, but not declared absent."""


@jit.generic(absent=0.5)
def value(rule: Any, x: float) -> float:
    """A number."""


@value.register(Silence)
def _value_of_silence(rule: Silence, x: float) -> float:
    return 10.0 * x


@jit.generic(absent=(1.0, 2.0))
def pair(rule: Any, x: float) -> tuple[float, float]:
    """Two numbers."""


@jit.generic(absent=lambda rule, x: -x)
def turned(rule: Any, x: float) -> float:
    """A number that a function gives."""


@jit.generic(absent=None)
def fill(rule: Any, x: float) -> None:
    """Nothing is returned."""


@jit.generic
def demanded(rule: Any, x: float) -> float:
    """What even nothing must say."""


@jit.generic(absent=0.0, otherwise=lambda rule, x: 3.0 * x)
def anyhow(rule: Any, x: float) -> float:
    """What every type has."""


@numba.njit
def everything(rule: Any, x: float) -> Any:
    return value(rule, x), pair(rule, x), turned(rule, x), fill(rule, x), anyhow(rule, x)


def test_a_type_that_stands_for_nothing_says_so_once() -> None:
    for run in (everything, everything.py_func):
        assert run(Nothing(), 2.0) == (0.5, (1.0, 2.0), -2.0, None, 0.0)
        assert run(Silence(), 2.0) == (20.0, (1.0, 2.0), -2.0, None, 0.0)


def test_what_every_type_has_needs_no_registration() -> None:
    assert anyhow(Forgotten(), 2.0) == compiled_anyhow(Forgotten(), 2.0) == 6.0


@numba.njit
def compiled_anyhow(rule: Any, x: float) -> float:
    return anyhow(rule, x)


@pytest.mark.parametrize(("function", "rule"), [(value, Forgotten()), (demanded, Nothing())])
def test_only_types_declared_absent_fall_back_and_only_where_nothing_has_a_value(function: Any, rule: Any) -> None:
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


def test_types_are_told_apart_without_the_compiler_too() -> None:
    without = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    run = subprocess.run([sys.executable, "-c", UNCOMPILED], capture_output=True, text=True, env=without)
    assert run.stdout == "`mu` is not registered for Verlet: @mu.register(Verlet)\n", run.stderr


@numba.njit
def force(law: Any, delta: float, v: float) -> float:
    return normal_force(law, delta, v)


@pytest.mark.parametrize(
    "law",
    [
        HuntCrossley(TenNinths(1e9), 50.0),
        Kraemer(TenNinths(1e9), 1e-5),
        general(TenNinths(1e9), 1e6, 1.5, 0.7),
    ],
    ids=lambda law: type(law).__name__,
)
@pytest.mark.parametrize("delta", [-1e-6, 0.0, 1e-7, 3e-6])
def test_contact_laws_from_python_equal_the_compiled_ones(law: Any, delta: float) -> None:
    for v in (-0.5, -0.01, 0.0, 0.01, 0.5):
        assert force(law, delta, v) == pytest.approx(normal_force(law, delta, v), rel=1e-13, abs=1e-15)


def test_add_may_reorder_but_nothing_forgets_what_is_not_finite() -> None:
    @numba.njit(**jit.OPTIONS)
    def total(values: np.ndarray) -> float:
        found = 0.0
        for k in range(len(values)):
            found = jit_add(found, values[k])
        return found if np.isfinite(found) else -1.0

    jit_add = jit.add
    values = np.random.default_rng(5).normal(size=1000)
    assert total(values) == pytest.approx(values.sum(), rel=1e-12)
    values[500] = np.nan
    assert total(values) == -1.0
