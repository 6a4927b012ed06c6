"""CPU clock for compiled code. Long loops read it occasionally and end when the job's CPU time is used up.

``cpu_time.bounded`` calls a function with such a loop and passes the end time. A reading takes 0.3 us.
"""

import time
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload

from bearingsim.core.jit import OPTIONS, jit

CLOCK_ID = getattr(time, "CLOCK_THREAD_CPUTIME_ID", None)  # of clock_gettime; None if the system lacks it
INT64, INT32 = ir.IntType(64), ir.IntType(32)


def thread_seconds() -> float:
    """Return the CPU time (s) of this thread; compiled code returns 0 if the system does not report it."""
    return time.thread_time()


@intrinsic
def system_thread_seconds(typing_context: Any) -> Any:
    """Compile ``thread_seconds`` as a call of the system's ``clock_gettime``."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        if CLOCK_ID is None:
            return context.get_constant(types.float64, 0.0)
        timespec = ir.LiteralStructType([INT64, INT64])  # seconds, nanoseconds
        pointer = cgutils.alloca_once(builder, timespec)
        function_type = ir.FunctionType(INT32, [INT32, timespec.as_pointer()])
        call = cgutils.get_or_insert_function(builder.module, function_type, "clock_gettime")
        builder.call(call, [ir.Constant(INT32, CLOCK_ID), pointer])
        seconds, nanoseconds = (
            builder.sitofp(builder.load(cgutils.gep_inbounds(builder, pointer, 0, n)), ir.DoubleType())
            for n in (0, 1)
        )
        return builder.fadd(seconds, builder.fmul(nanoseconds, ir.Constant(ir.DoubleType(), 1e-9)))

    return types.float64(), codegen


@overload(thread_seconds, jit_options=OPTIONS, strict=False)
def _thread_seconds():
    return lambda: system_thread_seconds()


@jit
def is_over(end):
    """Check if the CPU time of this thread is past ``end`` (s); 0 and inf are never past."""
    return 0.0 < end < thread_seconds()
