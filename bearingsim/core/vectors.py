"""Sums and products of rows in vector registers, eight doubles at once.

numba's compiler vectorises a loop over lanes, but not a sum over harmonics (or rollers) for each lane, which
requires the lanes to stay in registers during the loop, nor a dot product, whose sum it may not reorder.
These loops are therefore written in LLVM IR (numba intrinsics). Eight doubles are one register of AVX-512, two of
AVX2, four of SSE2 or NEON. The order of each sum is the same on all of them, and so is every bit of the result on
processors with fused multiply-add.

Gain: a run of `rollers` with a flexible ring takes 0.082 s of CPU time instead of 0.196 s with plain loops (x86-64
server, 2 cores; ``python -m benchmarks.compiler_gains``).
"""

from typing import Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic, overload

from bearingsim.core.jit import OPTIONS
from bearingsim.core.layout import VECTOR_WIDTH

INLINE_OPTIONS = OPTIONS | {"forceinline": True}

VECTOR = ir.VectorType(ir.DoubleType(), VECTOR_WIDTH)
UNDEFINED = ir.Constant(VECTOR, ir.Undefined)
ZEROS = ir.Constant(VECTOR, [0.0] * VECTOR_WIDTH)
BROADCAST_INDICES = ir.Constant(ir.VectorType(ir.IntType(32), VECTOR_WIDTH), [0] * VECTOR_WIDTH)
PARTIAL_SUMS = 2 * VECTOR_WIDTH  # partial sums of `dot`: two registers hide the latency of an addition
FUSION_FLAGS: Any = ("contract",)  # a product and an addition may be fused, as everywhere in the core


def weighted_rows(
    builder: Any, y: Any, rows: list[Any], table: Any, shape: tuple[Any, Any], lane: Any
) -> list[Any]:
    """Return for each of ``rows`` sum_i y[row + i] table[i, lane:lane + 8] as a vector.

    y, table: pointers; shape: of the table; the other arguments are integers.
    """
    totals = [cgutils.alloca_once(builder, VECTOR) for _ in rows]
    for total in totals:
        builder.store(ZEROS, total)
    with cgutils.for_range(builder, shape[0]) as loop:
        lanes = builder.gep(table, [builder.add(builder.mul(loop.index, shape[1]), lane)])
        values = builder.load(builder.bitcast(lanes, VECTOR.as_pointer()), align=8)
        for row, total in zip(rows, totals, strict=True):
            weight = builder.load(builder.gep(y, [builder.add(row, loop.index)]))
            weights = builder.insert_element(UNDEFINED, weight, ir.Constant(ir.IntType(32), 0))
            weights = builder.shuffle_vector(weights, UNDEFINED, BROADCAST_INDICES)
            product = builder.fmul(weights, values, flags=FUSION_FLAGS)
            builder.store(builder.fadd(product, builder.load(total), flags=FUSION_FLAGS), total)
    return [builder.load(total) for total in totals]


def split_halves(context: Any, builder: Any, array_type: Any, value: Any) -> tuple[list[Any], tuple[Any, Any]]:
    """Return the pointers to the two halves of an array (2, n, m), and the shape (n, m) of each."""
    array = context.make_array(array_type)(context, builder, value)
    _, n, m = cgutils.unpack_tuple(builder, array.shape)
    return [array.data, builder.gep(array.data, [builder.mul(n, m)])], (n, m)


def store_vector(builder: Any, y: Any, cell: Any, vector: Any) -> None:
    """Write a vector to ``y[cell:cell + 8]``."""
    builder.store(vector, builder.bitcast(builder.gep(y, [cell]), VECTOR.as_pointer()), align=8)


def sum_harmonics(
    tables: np.ndarray, rows_c: tuple, rows_s: tuple, y: np.ndarray, lane: int, cells: tuple
) -> None:
    """Set y[cell + k] = sum_i y[row_c + i] tables[0, i, lane + k] + y[row_s + i] tables[1, i, lane + k].

    For k from 0 to 7, and for each row_c of ``rows_c``, row_s of ``rows_s`` and cell of ``cells`` (integer tuples
    of equal length). tables: (2, n, m), in C order: cosines and sines.
    """
    n, lanes = tables.shape[1], slice(lane, lane + VECTOR_WIDTH)
    for row_c, row_s, cell in zip(rows_c, rows_s, cells, strict=True):
        cosine_sum, sine_sum = (
            y[row : row + n] @ table[:, lanes] for row, table in zip((row_c, row_s), tables, strict=True)
        )
        y[cell : cell + VECTOR_WIDTH] = cosine_sum + sine_sum


def sum_rollers(tables: np.ndarray, row: int, y: np.ndarray, lane: int, cells: tuple) -> None:
    """Set y[cells[0] + k] = sum_j y[row + j] tables[0, j, lane + k], and likewise for cells[1] and tables[1]."""
    n, lanes = tables.shape[1], slice(lane, lane + VECTOR_WIDTH)
    for table, cell in zip(tables, cells, strict=True):
        y[cell : cell + VECTOR_WIDTH] = y[row : row + n] @ table[:, lanes]


def dot(a: np.ndarray, b: np.ndarray, n: int) -> float:
    """Return the sum of a[k] b[k] over the first n; a, b: contiguous float64 (n or more,).

    Product k is added to partial sum k mod 16, up to the last multiple of 16. The partial sums are added in pairs
    whose numbers differ by 8, 4, 2 and 1, and the remaining products to the result.
    """
    end = n // PARTIAL_SUMS * PARTIAL_SUMS
    sums = np.zeros(PARTIAL_SUMS)
    for k in range(0, end, PARTIAL_SUMS):
        sums += a[k : k + PARTIAL_SUMS] * b[k : k + PARTIAL_SUMS]
    while len(sums) > 1:
        sums = sums[: len(sums) // 2] + sums[len(sums) // 2 :]
    total = float(sums[0])
    for k in range(end, n):
        total += a[k] * b[k]
    return total


# Compiled implementations


def load_vector(builder: Any, a: Any, k: Any) -> Any:
    """Read ``a[k:k + 8]`` as a vector."""
    return builder.load(builder.bitcast(builder.gep(a, [k]), VECTOR.as_pointer()), align=8)


def add_halves(builder: Any, vector: Any, width: int) -> Any:
    """Return the sum of the first and the second half of a vector of ``width`` lanes."""
    lanes = [list(range(start, start + width // 2)) for start in (0, width // 2)]
    indices = [ir.Constant(ir.VectorType(ir.IntType(32), width // 2), half) for half in lanes]
    undefined = ir.Constant(vector.type, ir.Undefined)
    return builder.fadd(*(builder.shuffle_vector(vector, undefined, half) for half in indices))


def sum_of_lanes(builder: Any, vector: Any) -> Any:
    """Return the sum of the lanes of a vector, added in pairs of lanes 4, 2 and 1 apart."""
    width = VECTOR_WIDTH
    while width > 1:
        vector = add_halves(builder, vector, width)
        width //= 2
    return builder.extract_element(vector, ir.Constant(ir.IntType(32), 0))


@intrinsic
def dot_in_registers(typing_context: Any, a: Any, b: Any, end: Any) -> Any:
    """Compile the part of ``dot`` up to ``end``, a multiple of PARTIAL_SUMS."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        left, right = (
            context.make_array(kind)(context, builder, value).data
            for kind, value in zip(signature.args[:2], arguments[:2], strict=True)
        )
        totals = [cgutils.alloca_once_value(builder, ZEROS) for _ in range(2)]
        step = ir.Constant(arguments[2].type, PARTIAL_SUMS)
        with cgutils.for_range(builder, builder.udiv(arguments[2], step)) as loop:
            start = builder.mul(loop.index, step)
            for part, total in enumerate(totals):
                k = builder.add(start, ir.Constant(start.type, part * VECTOR_WIDTH))
                product = builder.fmul(
                    load_vector(builder, left, k), load_vector(builder, right, k), flags=FUSION_FLAGS
                )
                builder.store(builder.fadd(product, builder.load(total), flags=FUSION_FLAGS), total)
        return sum_of_lanes(builder, builder.fadd(*(builder.load(total) for total in totals)))

    return types.float64(a, b, types.intp), codegen


@overload(dot, jit_options=INLINE_OPTIONS, strict=False)
def _dot(a, b, n):
    if any(kind.layout != "C" or kind.dtype != types.float64 for kind in (a, b)):
        raise TypingError("`dot` needs contiguous arrays of float64")

    def implementation(a, b, n):
        end = n // PARTIAL_SUMS * PARTIAL_SUMS
        total = dot_in_registers(a, b, end)
        for k in range(end, n):
            total += a[k] * b[k]
        return total

    return implementation


@intrinsic
def harmonics_in_registers(
    typing_context: Any, tables: Any, rows_c: Any, rows_s: Any, y: Any, lane: Any, cells: Any
) -> Any:
    """Compile ``sum_harmonics``."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        starts, shape = split_halves(context, builder, signature.args[0], arguments[0])
        cosine_rows, sine_rows, cells = (cgutils.unpack_tuple(builder, arguments[n]) for n in (1, 2, 5))
        buffer = context.make_array(signature.args[3])(context, builder, arguments[3]).data
        cosine_sums, sine_sums = (
            weighted_rows(builder, buffer, rows, start, shape, arguments[4])
            for rows, start in zip((cosine_rows, sine_rows), starts, strict=True)
        )
        for cell, sum_c, sum_s in zip(cells, cosine_sums, sine_sums, strict=True):
            store_vector(builder, buffer, cell, builder.fadd(sum_c, sum_s))
        return context.get_dummy_value()

    pair = types.UniTuple(types.intp, len(cells))
    return types.void(tables, pair, pair, y, types.intp, pair), codegen


@intrinsic
def rollers_in_registers(typing_context: Any, tables: Any, row: Any, y: Any, lane: Any, cells: Any) -> Any:
    """Compile ``sum_rollers``."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        table_value, row, y_value, lane, cells = arguments
        starts, shape = split_halves(context, builder, signature.args[0], table_value)
        buffer = context.make_array(signature.args[2])(context, builder, y_value).data
        sums = [weighted_rows(builder, buffer, [row], start, shape, lane)[0] for start in starts]
        for cell, total in zip(cgutils.unpack_tuple(builder, cells), sums, strict=True):
            store_vector(builder, buffer, cell, total)
        return context.get_dummy_value()

    return types.void(tables, types.intp, y, types.intp, types.UniTuple(types.intp, 2)), codegen


@overload(sum_harmonics, jit_options=INLINE_OPTIONS, strict=False)
def _sum_harmonics(tables, rows_c, rows_s, y, lane, cells):
    return lambda tables, rows_c, rows_s, y, lane, cells: harmonics_in_registers(
        tables, rows_c, rows_s, y, lane, cells
    )


@overload(sum_rollers, jit_options=INLINE_OPTIONS, strict=False)
def _sum_rollers(tables, row, y, lane, cells):
    return lambda tables, row, y, lane, cells: rollers_in_registers(tables, row, y, lane, cells)
