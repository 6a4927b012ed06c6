"""Gains of ``core/linking.py`` in compile time, and of ``core/vectors.py`` in the time of a step.

    python -m benchmarks.compiler_gains

Each variant runs in a separate process with its own cache: `rollers` with linked code and with default numba
compilation, and a flexible ring with sums in vector registers and with plain loops. About two minutes of CPU time.
"""

import os
import subprocess
import sys
import tempfile
import time

VARIANTS = ("linked", "by numba", "in registers", "in loops")
SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
SHORT = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "settle": "20 ms", "step_check": False}
FLEXIBLE_RING = {"rig": {"ring": {"bends": True}}}


def main() -> None:
    """Run every variant and print its CPU times."""
    for variant in VARIANTS:
        with tempfile.TemporaryDirectory() as cache:
            environment = os.environ | {"BEARINGSIM_CACHE": cache, "OPENBLAS_NUM_THREADS": "1"}
            subprocess.run(
                [sys.executable, "-m", "benchmarks.compiler_gains", variant], env=environment, check=True
            )


def measure(variant: str) -> None:
    """Print the CPU time (s) of the first run of a case, with compilation, and the shortest of five others."""
    is_flexible = variant in VARIANTS[2:]
    if variant == "by numba":
        disable_linking()
    if variant == "in loops":
        sum_in_loops()
    import bearingsim as bs

    fields = SHORT | {
        "model": "rollers",
        "method": "verlet",
        "defect": SLOT,
        "periodic": False,
        "duration": "60 ms",
    }
    case = bs.Case.model_validate(fields | (FLEXIBLE_RING if is_flexible else {}))
    seconds = []
    for _ in range(6):
        start = time.process_time()
        bs.simulate(case)
        seconds.append(time.process_time() - start)
    print(f"{variant}: first run {seconds[0]:.1f} s, others {min(seconds[1:]):.3f} s")


def disable_linking() -> None:
    """Disable linking, so that numba compiles by default."""
    from bearingsim.core import linking

    linking.HAS_INTERNALS = False
    linking.OPTIONS.clear()


def sum_in_loops() -> None:
    """Replace the sums of ``core/vectors.py`` by loops."""
    from bearingsim.core import vectors
    from bearingsim.core.jit import inlined
    from bearingsim.core.layout import VECTOR_WIDTH

    @inlined
    def sum_harmonics(tables, rows_c, rows_s, y, lane, to):
        for m in range(len(to)):
            for k in range(VECTOR_WIDTH):
                total_c, total_s = 0.0, 0.0
                for i in range(tables.shape[1]):
                    total_c += y[rows_c[m] + i] * tables[0, i, lane + k]
                    total_s += y[rows_s[m] + i] * tables[1, i, lane + k]
                y[to[m] + k] = total_c + total_s

    @inlined
    def sum_rollers(tables, row, y, lane, to):
        for m in range(2):
            for k in range(VECTOR_WIDTH):
                total = 0.0
                for i in range(tables.shape[1]):
                    total += y[row + i] * tables[m, i, lane + k]
                y[to[m] + k] = total

    vars(vectors).update(sum_harmonics=sum_harmonics, sum_rollers=sum_rollers)


if __name__ == "__main__":
    measure(sys.argv[1]) if len(sys.argv) > 1 else main()
