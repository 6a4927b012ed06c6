"""Vectorisation of compiled loops over rollers, read from their LLVM code."""

import re
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import pytest
from numba.core.registry import cpu_target

from bearingsim.core import jit

ROW = 100
# what a processor does on a vector; exp, log and pow look the same in this code, but are taken apart into calls
INSTRUCTIONS = r"llvm\.(fabs|sqrt|fma|fmuladd|maxnum|minnum|[su]max|[su]min|masked\.gather)\.v.*"
FEATURES = cpu_target.target_context.codegen().magic_tuple()[2]  # of the processor that code is made for
needs_vectors = pytest.mark.skipif(
    "+avx2" not in FEATURES, reason="the processor has no AVX2: no gathers, no wide integers"
)


def compiled(loop: Callable) -> Any:
    """``loop`` compiled with the core's options, uncached."""
    return numba.njit(**jit.OPTIONS)(loop)


def rows(*values: float) -> np.ndarray:
    """A flat buffer of rows, each filled with one of ``values``."""
    return np.repeat(np.array(values, dtype=float), ROW)


def keeps_lanes(loop: Any, *arguments: Any) -> bool:
    """Check if the loop of a compiled function is vectorised and calls no function."""
    loop(*arguments)
    code = loop.inspect_llvm(tuple(numba.typeof(argument) for argument in arguments))
    blocks = re.split(r"\n(?=[\w.]+:)", code)
    bodies = [block for block in blocks if block.startswith("vector.body")]
    names = {name for body in bodies for name in re.findall(r"call [^@\n]*@([\w.]+)\(", body)}
    calls = {name for name in names if not re.fullmatch(INSTRUCTIONS, name)}
    return bool(bodies) and "x double>" in "".join(bodies) and not calls
