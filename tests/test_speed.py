"""Evaluation of speed benchmarks: exponents, costs at an error, losses, prices. No times are measured."""

import json
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.models.interface import accelerations
from bearingsim.simulation.pricing import COEFFICIENT_FILE
from benchmarks.rows import write_csv
from benchmarks.speed import accuracy, compare, peers, prices, timing
from benchmarks.speed.report import Section, Target
from benchmarks.speed.scenes import case
from benchmarks.speed.timing import Measure


def run(processor: str = "one", **measures: Measure) -> dict[str, Any]:
    """A run as its file is read back."""
    section = Section(measures=measures)
    content = {"machine": {"processor": processor}, "sections": {"steps": section.to_json()}}
    run_: dict[str, Any] = json.loads(json.dumps(content))
    return run_


def measure(seconds: float, yardstick: float = 1.0, noise: float = 0.01) -> Measure:
    return Measure(seconds, yardstick, noise, 9)


class TestCompare:
    """A loss is an increase beyond noise, relative to the yardstick of its own run."""

    def test_loss_beyond_noise_is_flagged(self) -> None:
        (change,) = compare.changes(run(step=measure(1.15)), run(step=measure(1.0)))
        assert change.is_loss
        assert not change.is_gain
        assert str(change).startswith("LOSS  step: 1.15")

    def test_noise_is_no_loss(self) -> None:
        (change,) = compare.changes(run(step=measure(1.15, noise=0.04)), run(step=measure(1.0, noise=0.04)))
        assert not change.is_loss

    def test_small_change_is_no_loss(self) -> None:
        (change,) = compare.changes(run(step=measure(1.09, noise=0.0)), run(step=measure(1.0, noise=0.0)))
        assert not change.is_loss

    def test_gain_is_reported(self) -> None:
        (change,) = compare.changes(run(step=measure(0.8)), run(step=measure(1.0)))
        assert change.is_gain
        assert not change.is_loss

    def test_slower_machine_is_no_loss(self) -> None:
        (change,) = compare.changes(run(step=measure(2.0, yardstick=2.0)), run(step=measure(1.0)))
        assert change.ratio == pytest.approx(1.0)
        assert not change.is_loss

    def test_loss_on_faster_machine_is_flagged(self) -> None:
        (change,) = compare.changes(run(step=measure(0.8, yardstick=0.5)), run(step=measure(1.0)))
        assert change.is_loss

    def test_missing_measure_is_reported(self) -> None:
        assert compare.missing_measures(run(step=measure(1.0)), run(step=measure(1.0), forces=measure(1.0))) == [
            "forces"
        ]

    def test_exit_status_is_1_with_a_loss(self, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
        old, slow, same = (tmp_path / f"{name}.json" for name in ("old", "slow", "same"))
        old.write_text(json.dumps(run(step=measure(1.0), forces=measure(1.0))))
        slow.write_text(json.dumps(run("another", step=measure(1.3), forces=measure(1.0))))
        same.write_text(json.dumps(run(step=measure(1.02), forces=measure(0.98))))
        assert compare.main([str(slow), str(old)]) == 1
        output = capsys.readouterr().out
        assert "another processor" in output
        assert "2 measures: 1 lost, 0 won" in output
        assert compare.main([str(same), str(old)]) == 0

    def test_committed_baseline_has_no_loss_against_itself(self) -> None:
        assert compare.main([str(compare.BASELINE), str(compare.BASELINE)]) == 0
        assert len(compare.measures(json.loads(compare.BASELINE.read_text()))) > 50


class TestNumbers:
    """Evaluation of times."""

    @pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
    def test_exponent_of_power_law(self, power: float) -> None:
        sizes = np.array([8.0, 16.0, 32.0, 64.0])
        assert timing.exponent(sizes, 3e-7 * sizes**power) == pytest.approx(power)

    def test_exponent_of_noisy_times(self) -> None:
        sizes = np.array([8.0, 16.0, 32.0, 64.0])
        assert timing.exponent(sizes, sizes * np.array([1.02, 0.98, 1.01, 0.99])) == pytest.approx(1.0, abs=0.03)

    def test_growth_above_bound_misses_target(self) -> None:
        section = Section()
        section.add_growth("a step", "rollers", [8, 16, 32], [1.0, 2.2, 4.84])
        (target,) = section.targets
        assert not target.met
        assert target.found == pytest.approx(np.log2(2.2))

    def test_cost_between_points_is_interpolated_in_log_log(self) -> None:
        assert timing.cost_at(1e-3, [1e-2, 1e-4], [1.0, 100.0]) == pytest.approx(10.0)

    def test_dominated_point_is_ignored(self) -> None:
        assert timing.cost_at(1e-3, [1e-2, 5e-2, 1e-4], [1.0, 5.0, 100.0]) == pytest.approx(10.0)

    def test_cost_at_large_error_is_that_of_cheapest_point(self) -> None:
        assert timing.cost_at(1e-1, [1e-4, 1e-2], [100.0, 1.0]) == 1.0

    def test_unreached_error_has_infinite_cost(self) -> None:
        assert timing.cost_at(1e-5, [1e-2, 1e-4], [1.0, 100.0]) == np.inf

    def test_noise_is_relative_difference_of_least_times(self) -> None:
        assert timing.noise(np.array([1.0, 1.1, 9.0, 1.0])) == pytest.approx(0.0)
        assert timing.noise(np.array([1.3, 1.0, 9.0])) == pytest.approx(0.3)
        assert timing.noise(np.array([1.0])) == 0.0

    def test_tasks_are_timed_in_turns_with_yardstick(self) -> None:
        turns: list[str] = []
        times = iter([9.0, 5.0, 3.0, 4.0])  # the first is not counted

        def first_task() -> float:
            turns.append("one")
            return next(times)

        def second_task() -> float:
            turns.append("other")
            return 1.0

        with mock.patch.object(timing, "yardstick", return_value=0.5):
            measures = timing.measure_in_turns({"one": first_task, "other": second_task}, rounds=3)
        assert turns == ["one", "other"] * 4
        assert (measures["one"].seconds, measures["one"].yardstick, measures["one"].rounds) == (3.0, 0.5, 3)

    def test_targets_are_bounds(self) -> None:
        assert Target("ratio", 0.7, at_most=0.75).met
        assert not Target("ratio", 0.8, at_most=0.75).met
        assert Target("ratio", 120.0, at_least=100.0).met
        assert not Target("ratio", 90.0, at_least=100.0).met
        assert not Target("ratio", float("nan"), at_most=0.75).met


class TestAccuracy:
    """Evaluation of runs at several settings."""

    @staticmethod
    def runs(method: str, errors: list[float], seconds: list[float], ours: bool) -> list[accuracy.Run]:
        def result(error: float, cpu_s: float) -> accuracy.Result:
            return cpu_s, np.array(error)

        points = enumerate(zip(errors, seconds, strict=True))
        return [accuracy.Run(method, k, partial(result, *point), float, ours) for k, point in points]

    def test_costs_at_equal_error_without_measures_of_peers(self) -> None:
        section = Section()
        runs = self.runs("verlet", [1e-2, 1e-4], [1.0, 4.0], True) + self.runs("peer", [1e-3], [9.0], False)
        (costs,) = accuracy.costs_of(runs, "scene", 0.5, (1e-3,), section)
        assert costs == {"verlet": pytest.approx(4.0), "peer": pytest.approx(18.0)}
        assert list(section.measures) == ["scene/verlet at 0.001"]
        assert section.measures["scene/verlet at 0.001"].seconds == pytest.approx(2.0)
        assert [curve.method for curve in section.curves] == ["verlet", "peer"]

    def test_failed_run_is_no_point(self) -> None:
        section = Section()
        accuracy.costs_of(self.runs("verlet", [np.nan, 1e-4], [np.nan, 4.0], True), "scene", 1.0, (1e-3,), section)
        assert section.curves[0].errors == [1e-4]

    def test_cheapest_own_method_is_no_peer(self) -> None:
        assert accuracy.cheapest_own({"SciPy LSODA": 1.0, "rk4": 2.0, "verlet": 3.0}) == ("rk4", 2.0)


class TestPeers:
    """All peers integrate the same equations; missing ones are named."""

    def test_problem_of_peers_has_accelerations_of_model(self) -> None:
        model = assemble.model(case("rollers"))
        y, _ = assemble.start(case("rollers"), model)
        y[lay.RADIAL_V : lay.RADIAL_V + 13] = np.linspace(-0.01, 0.01, 13)
        problem = peers.problem(model, y, np.array([1e-5]))
        du = np.empty_like(problem.u)
        problem.derivatives(3.0, problem.u, du, problem.y)
        accelerations(model, 3e-6, y)
        assert problem.instants == pytest.approx([10.0])
        assert du[:13] == pytest.approx(np.linspace(-0.01, 0.01, 13), rel=1e-12)
        assert du[15:28] == pytest.approx(1e-6 * y[lay.RADIAL_A : lay.RADIAL_A + 13], rel=1e-9)
        expected = 1e-6 * y[lay.ACCELERATION : lay.ACCELERATION + 2]
        assert du[problem.ring] == pytest.approx(expected, rel=1e-9)
        assert np.abs(du[15:]).min() > 0.0

    def test_missing_peer_is_reported_and_others_run(self) -> None:
        def refuse(name: str) -> Any:
            raise ImportError(f"No module named '{name}'")

        with mock.patch.object(peers, "import_module", refuse):
            section = Section(missing=peers.missing_peers())
            model = assemble.model(case("rollers"))
            y, _ = assemble.start(case("rollers"), model)
            names = [name for name, _ in peers.solvers(peers.problem(model, y, np.array([1e-5])))]
        assert list(section.missing) == list(peers.PACKAGES)
        assert any("numbalsoda is not here: No module named 'numbalsoda'" in line for line in section.lines())
        assert names == ["SciPy LSODA", "SciPy DOP853", "SciPy RK45"]


class TestPrices:
    """A proposal is a separate file; the table is not changed."""

    def test_proposal_replaces_measured_prices_only(self, tmp_path: Path) -> None:
        content = COEFFICIENT_FILE.read_bytes()
        rows = prices.proposal({("evaluation", "ring"): 1e-7, ("step", "new"): 3.0})
        write_csv(rows, tmp_path / "prices.csv")
        by_key = {(row["what"], row["name"]): row for row in rows}
        assert by_key["evaluation", "ring"]["value"] == "1e-07"
        assert by_key["passes", ""]["new/old"] == "not measured"
        assert by_key["step", "new"]["new/old"] == "new row"
        assert COEFFICIENT_FILE.read_bytes() == content

    def test_ratio_is_to_committed_price(self) -> None:
        committed = {(row["what"], row["name"]): float(row["value"]) for row in prices.proposal({})}
        doubled = prices.proposal({key: 2.0 * value for key, value in committed.items()})
        assert {row["new/old"] for row in doubled} == {"2.00"}
