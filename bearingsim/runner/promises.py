"""What is said at the end of a run of the accuracy that its study names: models, how many hold it, audits."""

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from bearingsim import store
from bearingsim.store.spread import errors
from bearingsim.study.uncertainty import UNKNOWNS

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["held", "promises"]


def promises(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """All of it; nothing of a study that names none."""
    accuracy = plan.get("accuracy")
    if accuracy is None:
        return
    within = f"{100.0 * accuracy['within']:.3g} %"
    models = Counter(one["model"] for one in accuracy["jobs"].values())
    told = ", ".join(f"`{model}` in {count}" for model, count in models.most_common())
    yield f"models for {within} of {', '.join(accuracy['of'])}: {told} of {len(accuracy['jobs'])} cases"
    yield from accuracy["notes"]
    found = list(store.audited(plan, frame))
    if found:
        kept = sum(one.off <= accuracy["within"] + one.scatter for one in found)
        worst = 100.0 * max(one.off for one in found)
        yield (
            f"audit: {kept} of {len(found)} jobs computed again by their reference kept it;"
            f" the worst is {worst:.2g} % off"
        )
    moved = {name.split(".")[1] for name in errors(plan, frame).columns}
    unknown = [what for what in UNKNOWNS if what not in moved]
    if unknown:
        yield f"not examined beside it: what {', '.join(unknown)} move"


def held(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """How many cases are as close as their study asks; nothing of one that asks for nothing."""
    accuracy = plan.get("accuracy")
    if accuracy is None:
        return
    near = store.nearness(plan, frame)
    done = [job for job in accuracy["jobs"] if frame["status"].get(job) == "done"]
    sums = near.loc[done, ["error.model", "error.step", "error.scatter"]].sum(axis=1, skipna=False).dropna()
    close = int((sums <= accuracy["within"]).sum())
    within, longer = f"{100.0 * accuracy['within']:.3g} %", _longer(near, sums, accuracy)
    if done:
        yield f"accuracy of {within}: {close} of {len(done)} cases hold it, against the reference model{longer}"
    if len(sums) < len(done):
        count = len(done) - len(sums)
        yield f"of {count} chaotic cases the scatter of a line is not known, and so not whether they hold it"


def _longer(near: "pd.DataFrame", sums: "pd.Series[float]", accuracy: Mapping[str, Any]) -> str:
    """What those need that do not hold it, if that is a longer record."""
    over = sums[sums > accuracy["within"]].index
    scattered = near.loc[over, "error.scatter"]
    left = accuracy["within"] - near.loc[over, ["error.model", "error.step"]].sum(axis=1)
    longer = ((scattered / left) ** 2)[(left > 0.0) & (scattered > left)]
    return f"; {len(longer)} would with a `duration` {longer.max():.1f} times as long" if len(longer) else ""
