"""Changes by friction and a free cage of cases whose reference has none, tried where they may be largest.

A free cage never repeats itself, so a trial with it costs as much as many that do. It is made at both ends of each
curve, and where the curve is largest; the cases in between are taken to change by no more, and an audit looks at
some of them. What a record is too short to tell is computed with friction.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from math import inf

from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.selection.candidates import with_friction
from bearingsim.selection.curves import Curve, extremes
from bearingsim.selection.evidence import Evidence, largest
from bearingsim.selection.trials import Trialled, trials_of
from bearingsim.simulation.settling import settled
from bearingsim.simulation.trial import CAGE_TURNS, LARGEST_FORCE, Against, long_enough, tells_friction

CLEARLY = 2.0
"""Times what friction may change: a trial that has changed by more after two turns of the cage ends there."""

TOO_SHORT = f"the record holds fewer than {CAGE_TURNS} turns of the cage, too few to assess friction"
NOT_REPEATING = (
    f"without friction it is not periodic, and half the record covers under {CAGE_TURNS} turns of the cage"
)


class Friction:
    """Changes by friction of the cases that leave it open, as far as trials show them.

    tried: numbers of the cases that are tried; limit: what it may change at most (share).
    """

    def __init__(self, evidence: Evidence, tried: Sequence[int], drawn: Sequence[Curve], limit: float) -> None:
        self.evidence, self.limit = evidence, limit
        cases = evidence.study.cases()
        self.rubbing = {n: case for n in tried if (case := with_friction(cases[n])) is not None}
        short = {n for n in self.rubbing if not tells_friction(cases[n])}
        able = [n for n in self.rubbing if evidence.of_reference[n] and n not in short]
        few = {n for n in able if evidence.turns(n) < CAGE_TURNS}
        seen = [n for n in able if n not in few]
        self.untold = dict.fromkeys(few, NOT_REPEATING) | dict.fromkeys(short, TOO_SHORT)
        on_one = [Curve(curve.feature, tuple(n for n in curve.cases if n in seen)) for curve in drawn]
        alone = set(seen) - {n for curve in on_one for n in curve.cases}
        self.curves = [curve for curve in on_one if curve.cases] + [Curve("", (n,)) for n in sorted(alone)]

    @cached_property
    def extremes(self) -> list[int]:
        """The cases that are tried with friction: of each curve both ends, and that of the largest value."""
        return list(dict.fromkeys(n for curve in self.curves for n in extremes(curve, self.evidence.of_reference)))

    def trials(self) -> list[Trialled]:
        """Return the trials with friction that are still to be computed."""
        trials = [trial for n in self.extremes for trial in self._trials_of(n)]
        return [trial for trial in trials if trial.id not in self.evidence.known]

    def _trials_of(self, n: int) -> list[Trialled]:
        """Return the trials of a case with friction, which may end early, and of its healthy counterpart."""
        own, *baselines = trials_of(self.evidence.study, n, self._tried(n))
        plain = self.evidence.of_reference[n]
        names = [name for name in own.asked if name in plain and name != LARGEST_FORCE]
        most = {name: CLEARLY * self.limit * self.evidence.sizes[name][n] for name in names}
        against = Against({name: plain[name].value for name in names}, most)
        return [replace(own, against=(against,)), *baselines]

    def _tried(self, n: int) -> Case:
        """Return the case that is tried with friction for number ``n``: itself, if its record may end early.

        Any other settles as long as without: what the cage still remembers then is within what turns of it scatter
        by.
        """
        case, plain = self.rubbing[n], self.evidence.study.cases()[n]
        if case.until is not None and long_enough(case) == case:
            return case
        with suppress(Refused):  # the trial reports it
            case = case.model_copy(update={"settle": settled(plain).settle})
        return long_enough(case)

    @cached_property
    def _changes_at_extremes(self) -> dict[int, dict[str, float | None]]:
        """The change by friction of each case that is tried with it, by feature; None where its trial failed."""
        changes: dict[int, dict[str, float | None]] = {}
        for n in self.extremes:
            errors = self.evidence.errors(n, self._tried(n))
            changes[n] = dict(errors) if errors else dict.fromkeys(self.evidence.of_reference[n])
        return changes

    def errors(self, n: int) -> Mapping[str, float | None]:
        """Return the change by friction of a case, by feature: at most that of the tried cases on its curves.

        None where that is unknown; nothing of a case that does not leave friction open.
        """
        if n in self._changes_at_extremes:
            return self._changes_at_extremes[n]
        others = {other for curve in self.curves if n in curve.cases for other in curve.cases}
        changes = [
            self._changes_at_extremes[other] for other in sorted(others) if other in self._changes_at_extremes
        ]
        names = self.evidence.of_reference[n] if changes else ()
        return {name: largest([change[name] for change in changes]) for name in names}

    def inferred(self, n: int) -> bool:
        """Return whether the effect of friction to a case is taken from others on its curves."""
        return bool(self.errors(n)) and n not in self._changes_at_extremes

    @cached_property
    def too_much(self) -> dict[int, str]:
        """The cases that are computed with friction, and why: those on a curve that it changes too much."""
        reasons = dict(self.untold)
        for curve in self.curves:
            worst = max(
                (self._largest_at(n) for n in curve.cases if n in self._changes_at_extremes), default=(0.0, "")
            )
            if worst[0] > self.limit:
                reasons |= dict.fromkeys(curve.cases, self._why(*worst))
        return reasons

    def _largest_at(self, n: int) -> tuple[float, str]:
        """Return the largest known change by friction of a case, and of which feature."""
        return max(
            ((of, name) for name, of in self._changes_at_extremes[n].items() if of is not None), default=(0.0, "")
        )

    def _why(self, off: float, name: str) -> str:
        if off == inf:
            return f"friction changes {name} too much, or the record has too few cage turns to tell"
        return (
            f"friction changes {name} by up to {100.0 * off:.2g} % on its curve, over {100.0 * self.limit:.2g} %"
        )
