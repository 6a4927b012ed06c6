"""What is said of the results at the end of a run."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from bearingsim import store
from bearingsim.config.names import NO_VALUE
from bearingsim.config.rules import damping
from bearingsim.runner.promises import promises
from bearingsim.runner.summary import chaos, repetitions, step_errors
from bearingsim.runner.unknowns import examined

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["of_results"]


def of_results(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """What is worth knowing of the planned jobs' results, and of what was varied of them."""
    own = frame.loc[[entry["job"] for entry in plan["jobs"] if not entry["variation"]]]
    yield from promises(plan, frame)
    yield from repetitions(store.info(own))
    yield from damping.of_jobs(store.info(own))
    yield from examined(plan, frame)
    yield from chaos(own)
    yield from step_errors(own)
    yield from without_value(store.info(own))


def without_value(info: "pd.DataFrame") -> Iterator[str]:
    """Name the features of other packages that jobs have no number for; ``info``: of finished jobs, a row each."""
    for column in (name for name in map(str, info) if name.startswith(NO_VALUE)):
        reasons = info[column][info[column] != ""]
        for reason, jobs in reasons.groupby(reasons):
            count = f"{len(jobs)} of {len(info)} jobs"
            feature = column.removeprefix(NO_VALUE)
            yield f"feature `{feature}` has no value in {count}: {reason} (for example {jobs.index[0]})"
