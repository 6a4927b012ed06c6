"""What is said at the end of a run of the accuracy that its study names: models, how many hold it, audits."""

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from bearingsim import store
from bearingsim.store.spread import errors
from bearingsim.study.uncertainty import UNKNOWNS

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["held", "promises", "withdrawals"]


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
    audits = _by_job(plan, frame)
    if audits:
        kept = sum(not any(audit.fails(accuracy["within"]) for audit in of_job) for of_job in audits.values())
        worst = 100.0 * max(audit.off for of_job in audits.values() for audit in of_job)
        yield (
            f"audit: {kept} of {len(audits)} jobs computed again by their reference kept it;"
            f" the worst is {worst:.2g} % off"
        )
    moved = {name.split(".")[1] for name in errors(plan, frame).columns}
    unknown = [what for what in UNKNOWNS if what not in moved]
    if unknown:
        yield f"not examined beside it: what {', '.join(unknown)} move"


def withdrawals(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """Yield a sentence if an audit failed: what it found, and of how many cases the promise is withdrawn."""
    refuted = store.withdrawn(plan, frame)
    if not refuted:
        return
    accuracy = plan["accuracy"]
    worst = max(store.audited(plan, frame), key=lambda audit: audit.off - audit.scatter)
    yield (
        f"accuracy of {100.0 * accuracy['within']:.3g} % withdrawn for {len(refuted)} of {len(accuracy['jobs'])}"
        f" cases: {worst.feature} of {worst.job} is {100.0 * worst.off:.2g} % off its reference"
        " (say `model: reference` to compute all by it)"
    )


def held(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """Yield how many cases are as close as their study asks; after a failed audit how many of the others are."""
    accuracy = plan.get("accuracy")
    if accuracy is None:
        return
    refuted, near = store.withdrawn(plan, frame), store.nearness(plan, frame)
    jobs = [job for job in accuracy["jobs"] if job not in refuted]
    done = [job for job in jobs if frame["status"].get(job) == "done"]
    sums = near.loc[done, [*store.PARTS]].sum(axis=1, skipna=False).dropna()
    close = int((sums <= accuracy["within"]).sum())
    within, longer = f"{100.0 * accuracy['within']:.3g} %", _longer(near, sums, accuracy)
    if done and refuted:
        yield f"of the other {len(done)} cases {close} are within {within} by their trials{longer}"
    elif done:
        yield f"accuracy of {within}: {close} of {len(done)} cases hold it, against the reference model{longer}"
    if len(sums) < len(done):
        count = len(done) - len(sums)
        yield f"of {count} chaotic cases the scatter of a line is not known, and so not whether they hold it"


def _by_job(plan: Mapping[str, Any], frame: "pd.DataFrame") -> dict[str, list[store.Audited]]:
    """Return what audits found, by the job that was audited."""
    audits: dict[str, list[store.Audited]] = {}
    for audit in store.audited(plan, frame):
        audits.setdefault(audit.job, []).append(audit)
    return audits


def _longer(near: "pd.DataFrame", sums: "pd.Series[float]", accuracy: Mapping[str, Any]) -> str:
    """What those need that do not hold it, if that is a longer record, or a finer discretisation."""
    over = sums[sums > accuracy["within"]].index
    scattered = near.loc[over, "error.scatter"]
    left = accuracy["within"] - near.loc[over, [name for name in store.PARTS if name != "error.scatter"]].sum(
        axis=1
    )
    longer = ((scattered / left) ** 2)[(left > 0.0) & (scattered > left)]
    told = f"; {len(longer)} would with a `duration` {longer.max():.1f} times as long" if len(longer) else ""
    nodes = near.loc[over, "error.nodes"]
    finer = int(((nodes > 0.0) & (sums[over] - nodes <= accuracy["within"])).sum())
    return told + (f"; {finer} would with more `contact.length_nodes` (slices, harmonics)" if finer else "")
