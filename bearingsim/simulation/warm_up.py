"""Compilation of the solvers of some cases before their first run."""

from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

from bearingsim import assemble, cpu_time
from bearingsim.config import Case, Section
from bearingsim.simulation import channels, choice
from bearingsim.simulation.pricing import coefficient
from bearingsim.simulation.run_setup import nested_types
from bearingsim.simulation.simulate import simulate

_COMPILED: set[tuple] = set()  # keys of the cases whose code is compiled or loaded in this process
WARM_UP_LIMIT = 0.3
"""CPU time (s) after which a ball pass is stopped, excluding compilation; functions that it has not called compile
during a job."""


def compile_solvers(cases: Iterable[Case], on_compile: Callable[[int, int, float], None] | None = None) -> None:
    """Compile the solvers of the cases (or load them from the cache) by computing one ball pass of each new kind.

    on_compile: called before each kind with its number (from 1), the number of kinds, and the estimated CPU time
    (s) of compilation.
    """
    kinds: dict[tuple, Case] = {}
    for case in cases:
        laws = assemble.contacts.build_outer_law(case), assemble.contacts.build_inner_law(case)
        kinds.setdefault(
            (_settings_key(choice.resolve(case)), nested_types(laws), channels.stores_raw_values(case)), case
        )
    new = {kind: case for kind, case in kinds.items() if kind not in _COMPILED}
    for number, (kind, case) in enumerate(new.items(), 1):
        if on_compile is not None:
            on_compile(number, len(new), coefficient("compile", case.model))
        duration = max(1.0 / case.bearing.ball_pass_frequency(case.speed), 1.0 / case.sampling)
        settings = {"duration": duration, "settle": 0.0, "step": "auto", "step_check": False}
        with suppress(cpu_time.OutOfCpuTime), cpu_time.at_most(WARM_UP_LIMIT):
            simulate(case.model_copy(update=settings))
        _COMPILED.add(kind)


def _settings_key(value: Any) -> Any:
    """Return the words and flags in a section and the types of its numbers, which determine the compiled code."""
    if isinstance(value, Section):
        return tuple(_settings_key(getattr(value, name)) for name in type(value).model_fields)
    if isinstance(value, tuple):
        return bool(value)
    return value if isinstance(value, str | bool | None) else type(value)
