"""Benchmarks: run each from the root of the checkout as ``python -m benchmarks.NAME``.

Linear algebra uses one thread, as in the command: CPU time of idle threads would be counted otherwise.
"""

from bearingsim import blas_threads

blas_threads.limit_to_one()
