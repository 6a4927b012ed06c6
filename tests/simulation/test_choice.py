"""Steps, and what they cost, before anything runs."""

import pickle
from math import sqrt
from typing import Any
from unittest import mock

import pytest

from bearingsim import assemble
from bearingsim.catalogue import METHODS
from bearingsim.config import Case
from bearingsim.core.methods.interface import Tolerances
from bearingsim.errors import Refused
from bearingsim.simulation import choice, pricing, time_grid
from bearingsim.simulation.choice import limits
from bearingsim.simulation.time_grid import make_grid, requested_step
from tests.scenes.nf308 import SLOT
from tests.scenes.slots import HEAVY, NARROW, SLOTS, case


@pytest.mark.parametrize("defect", [SLOT, NARROW])
def test_two_microseconds_are_too_long_for_verlet(defect: dict) -> None:
    with pytest.raises(Refused, match=r"a step of 2 us is over [\d.]+ us, 90% of the method's limit") as caught:
        requested_step(case(defect=defect, method="verlet", step="2 us", **HEAVY))
    assert "step: auto" in caught.value.advice
    assert f"{1e6 * requested_step(case(defect=defect, **HEAVY)):.2g} us" in caught.value.advice


@pytest.mark.parametrize("method", ["verlet", "rk4"])
def test_half_a_microsecond_is_accepted(method: str) -> None:
    test_case = case(defect=SLOT, method=method, step="0.5 us")
    assert requested_step(test_case) == 0.5e-6
    assert make_grid(test_case).step <= 0.5e-6


@pytest.mark.parametrize("defects", SLOTS)
@pytest.mark.parametrize("method", ["verlet", "rk4"])
def test_a_step_is_refused_exactly_above_the_limit(method: str, defects: tuple) -> None:
    settings = {"method": method, "defects": defects, "load": "300 N"}
    result = limits(case(**settings))
    assert requested_step(case(**settings, step=0.899 * result.at_impact)) == 0.899 * result.at_impact
    with pytest.raises(Refused):
        requested_step(case(**settings, step=0.901 * result.at_impact))


def test_step_is_limited_by_the_crossing_time_of_the_defect() -> None:
    crossing = limits(case(model="static", defect=NARROW)).crossing
    with pytest.raises(Refused, match="too few steps"):
        requested_step(case(model="static", defect=NARROW, step=crossing / 7))
    assert requested_step(case(model="static", defect=NARROW, step=crossing / 9)) == crossing / 9


@pytest.mark.parametrize(
    ("model", "method"),
    [("static", None), ("ring", "rk4"), ("ring", "verlet"), ("rollers", "rk4"), ("rollers", "verlet")],
)
@pytest.mark.parametrize("defects", SLOTS)
@pytest.mark.parametrize("chi", [0.01, 50.0])
def test_the_automatic_step_obeys_every_bound(model: str, method: str | None, defects: tuple, chi: float) -> None:
    test_case = case(model=model, method=method, defects=defects, contact={"damping": {"chi": chi}})
    result, chosen = limits(test_case), requested_step(test_case)
    bounds = [result.crossing / (100 if model == "rollers" else 50), 20e-6]
    if method:
        bounds.append({"verlet": 0.5, "rk4": 0.25}[method] * result.at_impact)
        bounds.append(1.0 / result.contact_frequency / {"verlet": 40, "rk4": 20}[method])
    assert chosen == pytest.approx(min(bounds), rel=1e-12)
    assert requested_step(test_case.model_copy(update={"step": chosen})) == chosen


@pytest.mark.parametrize("sampling", [200e3, 1024.0, 10240.0, 12345.678, 37.0])
@pytest.mark.parametrize("model", ["static", "ring"])
def test_grid_divides_ball_passes_and_covers_the_record(sampling: float, model: str) -> None:
    test_case = case(model=model, sampling=sampling, defect=SLOT, duration="0.3 s", settle="11 ms")
    grid = make_grid(test_case)
    assert grid.step <= requested_step(test_case) * (1 + 1e-12)
    assert grid.steps_per_pass * grid.step * 159.0 == pytest.approx(1.0, rel=1e-12)
    assert grid.fine_rate >= 4.0 * sampling * (1 - 1e-12)
    assert grid.fine_per_pass >= 64
    assert grid.passes / 159.0 >= 0.311 + 13.0 / sampling


def test_step_that_divides_the_fine_sample_is_kept() -> None:
    """A step that divides the fine sample exactly is kept, rather than replaced by a shorter one."""
    grid = make_grid(case(model="ring"))
    again = make_grid(case(model="ring", step=grid.step))
    assert again == grid


def test_a_record_without_samples_is_refused() -> None:
    with pytest.raises(Refused, match="no sample"):
        make_grid(case(duration="10 ms", sampling="50 Hz"))


def test_estimate_counts_steps_and_bytes() -> None:
    fields = {"duration": 0.29, "sampling": 10000.0, "record": ["ring.velocity", "roller.outer_force"]}
    test_case = case(model="ring", periodic=False, **fields)
    result, grid = time_grid.estimate(test_case), make_grid(test_case)
    assert result.bytes == 3 * 4 * 2900
    assert result.steps == grid.passes * grid.steps_per_pass
    assert time_grid.estimate(case(record=[])).bytes == 0


def test_static_computes_one_pass_for_outer_race_defects() -> None:
    outer, inner = (case(model="static", defect=SLOT | {"race": race}) for race in ("outer", "inner"))
    assert time_grid.estimate(outer).steps == make_grid(outer).steps_per_pass
    assert time_grid.estimate(inner).steps == make_grid(inner).passes * make_grid(inner).steps_per_pass


def test_a_step_error_survives_pickling() -> None:
    with pytest.raises(Refused) as caught:
        requested_step(case(defect=SLOT, method="verlet", step="2 us", **HEAVY))
    again = pickle.loads(pickle.dumps(caught.value))
    assert (again.reason, again.advice) == (caught.value.reason, caught.value.advice)


def test_contact_too_damped_for_explicit_steps_is_refused_before_allocation() -> None:
    """1e6 N s/mm as printed by the paper, with indentation exponent 0: steps of some picoseconds."""
    printed = {"law": "general", "coefficient": "1e6", "indentation_exponent": "0"}
    with pytest.raises(Refused, match=r"a ball pass would take .* steps") as caught:
        make_grid(case(model="rollers", method="verlet", defect=SLOT, contact={"damping": printed}))
    assert "contact.damping" in caught.value.advice


def test_adaptive_methods_receive_all_tolerance_parameters() -> None:
    for name, method in METHODS.items():
        parameters: Any = assemble.kind_of_method(name).parameters
        assert parameters._fields == (Tolerances._fields if method.adaptive else ("h",))


@pytest.mark.parametrize(("share", "is_verlet"), [(0.899, True), (0.901, False)])
def test_automatic_method_accepts_a_given_step(share: float, is_verlet: bool) -> None:
    """Verlet accepts steps up to 90 % of its limit at an impact; adaptive methods have no limit of stability."""
    step = share * limits(case(method="verlet", defect=SLOT)).at_impact
    given = case(method="auto", defect=SLOT, step=step)
    chosen = choice.choose_method(given).method
    assert (chosen == "verlet") == is_verlet
    assert is_verlet or METHODS[str(chosen)].adaptive
    assert requested_step(given) == step


def test_step_that_no_method_accepts_is_refused() -> None:
    """An eighth of the crossing time is the longest step of any method."""
    crossing = limits(case(method="verlet", defect=SLOT)).crossing
    with pytest.raises(Refused):
        requested_step(case(method="auto", defect=SLOT, step=crossing / 7.0))


def test_tolerance_leads_to_an_adaptive_method() -> None:
    """Verlet, the cheapest method here, has no tolerance."""
    test_case = case(defect=SLOT, duration="0.1 s")
    assert choice.choose_method(test_case).method == "verlet"
    result = choice.choose_method(test_case.model_copy(update={"tolerance": 1e-3}))
    assert result.method in result.costs
    assert all(METHODS[name].adaptive for name in result.costs)
    assert "tolerance" in result.reason


@pytest.mark.parametrize(
    ("name", "price", "chosen"),
    [
        ("dormand-prince", 0.99 / 1.2, "dormand-prince"),
        ("dormand-prince", 1.01 / 1.2, "verlet"),
        ("rodas", 0.99 / 2.0, "rodas"),
        ("rodas", 1.01 / 2.0, "verlet"),
    ],
)
def test_another_method_must_save_more_than_the_error_of_its_price(name: str, price: float, chosen: str) -> None:
    """The error is larger for implicit than for explicit adaptive methods."""
    prices = {"verlet": 1.0, name: price}

    def cost(priced: Case) -> pricing.Cost:
        return pricing.Cost(prices.get(str(priced.method), 9.0), 0.0, 0.0, 1, 0.0)

    test_case = case(model="rollers", defect=SLOT | {"race": "inner"}, duration="0.1 s")
    with mock.patch.object(choice, "_method_cost", cost):
        assert choice.choose_method.__wrapped__(test_case).method == chosen


@pytest.mark.parametrize("motion", ["free", "kinematic"])
def test_explicit_adaptive_methods_need_a_cage_without_friction(motion: str) -> None:
    test_case = case(model="planar", friction="none", cage={"motion": motion})
    assert choice.is_suitable(test_case, "dop853") == (motion == "kinematic")
    assert choice.is_suitable(test_case, "verlet")
    assert choice.is_suitable(test_case, "rodas")
    assert choice.is_suitable(case(model="rollers"), "dop853")


def test_implicit_method_is_chosen_for_stiff_contacts() -> None:
    stiff = case(model="rollers", defect=SLOT, duration="0.1 s", contact={"damping": {"chi": "2000 s/m"}})
    result, longest = choice.choose_method(stiff), limits(choice.with_method(stiff, "verlet")).at_impact
    assert result.method == "rodas"
    ratio = result.costs["verlet"] / result.costs["rodas"]
    reason = f"explicit steps are limited to {1e6 * longest:.2g} us: about {ratio:.2g} times the CPU time"
    assert (result.reason, ratio > 1.0, 1e-8 < longest < 1e-7) == (reason, True, True)


def test_step_is_shortened_to_an_eighth_at_its_price() -> None:
    attempt = choice.attempts(case(model="rollers", defect=SLOT, duration="0.1 s"))[0]
    half = attempt.shorter()
    assert half is not None
    assert (half.step_fraction, half.cost) == (0.5, pytest.approx(2.0 * attempt.cost))
    quarter = half.shorter()
    assert quarter is not None
    assert (quarter.step_fraction, quarter.cost) == (0.25, pytest.approx(4.0 * attempt.cost))
    assert half._replace(step_fraction=0.125).shorter() is None


@pytest.mark.parametrize("model", ["static", "impulse"])
def test_models_without_a_method_have_no_alternatives(model: str) -> None:
    assert choice.alternatives(case(model=model, defect=SLOT)) == []
    assert choice.choose_method(case(model=model, defect=SLOT)) == (None, f"{model} has no method", {})


def test_a_method_of_the_case_is_not_compared_with_others() -> None:
    assert choice.choose_method(case(model="rollers", method="verlet")) == ("verlet", "given by the case", {})


@pytest.mark.parametrize(("coefficient", "step_s"), [(10.0, 13.2e-6), (1e3, 1.71e-6), (1e5, 0.417e-6)])
def test_discontinuous_damping_shortens_adaptive_steps(coefficient, step_s):
    """Mean step of Rodas over a 0.8 mm slot, counted over 25 ms; uncorrected wrong up to 26-fold."""
    damping = {"law": "general", "coefficient": coefficient, "indentation_exponent": 0.0}
    test_case = case(method="rodas", defect=SLOT, contact={"damping": damping})
    result = pricing.adaptive_step(test_case, choice.limits(choice.with_method(test_case, "verlet")))
    assert result == pytest.approx(step_s, rel=0.5)


FLEXIBLE = {
    "ring": {"bends": True, "harmonics": 20},
    "load": {"by": "housing", "stiffness": "1e10 N/m/m"},
    "sensor": {"on": "ring", "angle": "0 deg"},
}


def test_bending_of_a_flexible_ring_shortens_adaptive_steps() -> None:
    """Mean step of dormand-prince over 30 ms: 2.3 us; 12.8 us by the stiffness of the contacts alone."""
    test_case = case(method="dormand-prince", defect=SLOT, rig=FLEXIBLE)
    result = pricing.adaptive_step(test_case, choice.limits(choice.with_method(test_case, "verlet")))
    assert 2.3e-6 < result < 2.1 * 2.3e-6


WAVES = {"outer": {"spectrum": {"amplitude": "0.2 um"}}}


@pytest.mark.parametrize(
    ("fields", "possible"),
    [
        ({"model": "rollers"}, True),
        ({"model": "rollers", "surfaces": WAVES}, True),
        ({"model": "planar"}, True),
        ({"model": "planar", "surfaces": WAVES}, False),
        ({"model": "rollers", "defect": SLOT, "rig": FLEXIBLE}, False),
    ],
)
def test_implicit_methods_need_the_derivatives_of_the_model(fields: dict[str, Any], possible: bool) -> None:
    """Not on wavy surfaces with slip, nor with a flexible ring, nor with an extension that lacks them."""
    assert choice.is_suitable(case(**fields), "rodas") == possible
    with mock.patch.object(choice, "missing_functions", return_value=["no derivative"]):
        assert not choice.is_suitable(case(**fields), "rodas")


def test_a_flexible_ring_that_may_repeat_is_stepped_by_verlet() -> None:
    """Verlet took 4.4 s, dormand-prince 4.8 s; extrapolation to the steady motion ends with the settling time."""
    test_case = case(defect=SLOT, rig=FLEXIBLE, duration="0.15 s")
    result = choice.choose_method(test_case)
    assert result.method == "verlet"
    assert result.costs["verlet"] < result.costs["dormand-prince"]


@pytest.mark.parametrize(("m1", "m3", "ns"), [(1.0, 1.0, 97), (1.0, 1.5, 413), (1.2, 1.0, 578), (1.2, 1.5, 625)])
def test_cost_of_general_exponents_is_estimated(m1: float, m3: float, ns: float) -> None:
    """Cost of a Verlet step of `rollers` by benchmarks/step_cost.py; without powers 4 to 6 times too small."""
    stiffness = {"law": "constant", "coefficient": 1e6, "exponent": m1}
    damping = {"law": "general", "coefficient": 100.0, "indentation_exponent": m3}
    test_case = case(method="verlet", contact={"stiffness": stiffness, "damping": damping})
    assert pricing.cpu_per_second(test_case, 1e-6) == pytest.approx(1e-3 * ns, rel=0.35)


def test_static_costs_one_pass_unless_periodic_is_false() -> None:
    test_case = case(model="static", defect=SLOT, duration="1 s")
    full = test_case.model_copy(update={"periodic": False})
    low_limit = mock.patch.object(time_grid, "MAX_CPU", 0.1 * time_grid.estimate(test_case).cpu_seconds)
    with low_limit, pytest.raises(Refused, match="`static` would take about"):
        make_grid(full)
    one_pass = time_grid.estimate(test_case).cpu_seconds - pricing.coefficient("job")
    with mock.patch.object(time_grid, "MAX_CPU", 2.0 * one_pass):
        make_grid(test_case)


def test_cost_of_a_job_includes_the_step_check() -> None:
    checks_step, plain = (
        time_grid.estimate(case(defect=SLOT | {"race": "inner"}, duration="2 s", step_check=step_check))
        for step_check in (True, False)
    )
    assert plain.check_seconds == 0.0
    assert checks_step.check_seconds == pytest.approx(sqrt(5) / 16 * plain.cpu_seconds, rel=0.1)
    assert checks_step.cpu_seconds == pytest.approx(plain.cpu_seconds + checks_step.check_seconds)


def test_cost_of_a_periodic_job_counts_the_expected_passes() -> None:
    test_case = case(defect=SLOT, method="verlet")
    long, short = (time_grid.estimate(test_case.model_copy(update={"duration": s})) for s in (20.0, 1.0))
    full = time_grid.estimate(test_case.model_copy(update={"duration": 20.0, "periodic": False}))
    assert long.steps == short.steps
    assert short.cpu_seconds < long.cpu_seconds < 0.05 * full.cpu_seconds  # its series are longer
    assert short.memory < long.memory < full.memory < full.max_memory
    assert full.max_memory == long.max_memory < 1.3 * full.memory  # passes are stored during integration only
    assert (
        full.cpu_seconds < long.max_seconds == full.max_seconds
    )  # the step check uses the period, if there is one
    assert 0.0 < long.check_seconds < long.cpu_seconds


def test_adaptive_steps_are_bounded_by_the_highest_speed_of_a_ramp() -> None:
    fields = {"model": "planar", "defect": SLOT, "method": "rodas"}
    ramp = case(**fields, ramp={"to": "3600 rpm", "time": "1 s"})
    slow, fast = case(**fields), case(**fields, speed="3600 rpm")
    longest = [assemble.method(variant, 1e-6).longest for variant in (slow, ramp, fast)]
    assert longest[1] == longest[2] == pytest.approx(0.5 * longest[0])
