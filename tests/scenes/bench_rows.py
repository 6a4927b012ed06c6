"""Constructed rows of charts."""

from math import nan

from bearingsim.bench import measure
from bearingsim.bench.measure import QUANTITIES
from bearingsim.bench.plan import POINT, REFERENCE


def row(
    variant="planar", role=POINT, method="verlet", cpu=1.0, value=1.0, setting="1 of the automatic step", **fields
):
    """Return the row of a run whose line, RMS and force are all ``value``."""
    empty = dict.fromkeys(measure.COLUMNS, nan) | {"failure": "", "reason": "", "key": "", "period_passes": 0}
    identity = {
        "scene": "s",
        "variant": variant,
        "model": fields.pop("model", variant),
        "role": role,
        "method": method,
        "setting": setting,
    }
    return empty | identity | {"cpu_per_s": cpu} | dict.fromkeys(QUANTITIES, value) | fields


def reference_rows(variant="planar", value=1.0, other=1.0 + 1e-4):
    return [row(variant, REFERENCE, value=value), row(variant, REFERENCE, "dop853", value=other, setting="1e-07")]
