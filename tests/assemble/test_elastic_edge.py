"""Excitation ``elastic-edge`` in a case: parameters and rejected cases."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.core.defects.edge_contact import EdgeContact
from bearingsim.simulation.simulate import simulate
from bearingsim.study.jobs import case_id
from tests.scenes.nf308 import CHI

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "50 um"}


def case(**fields: Any) -> Case:
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "excitation": "elastic-edge"}
    return Case.model_validate(base | {"contact": {"damping": CHI}} | fields)


def test_parameters_come_from_the_case() -> None:
    excitation = assemble.model(case(defect=SLOT | {"edge": {"radius": "10 um"}})).defects.excitation
    assert isinstance(excitation, EdgeContact)
    E_star = 207e9 / (2.0 * (1.0 - 0.3**2))
    assert excitation.scaled_load * 0.012 * 3.141592653589793 * E_star == pytest.approx(
        4.09 * 150 / 13 + 2.04, abs=0.5
    )  # N
    assert excitation.rho == 1e-5
    assert assemble.model(case(defect=SLOT)).defects.excitation.rho == 2e-5


@pytest.mark.parametrize(
    ("stiffness", "exponent"),
    [
        ("palmgren", 10.0 / 9.0),
        ({"law": "constant", "coefficient": 1e5, "exponent": 1.0}, 1.0),
        ({"law": "constant", "coefficient": 1e6, "exponent": 1.3}, 1.3),
    ],
)
def test_exponent_is_that_of_the_stiffness(stiffness: Any, exponent: float) -> None:
    given = case(defect=SLOT, contact={"damping": CHI, "stiffness": stiffness})
    assert assemble.model(given).defects.excitation.exponent == pytest.approx(exponent, rel=1e-12)


def test_exponent_of_johnson_is_that_at_the_largest_load() -> None:
    """d ln Q/d ln delta = Lambda/(Lambda - 1), Lambda = 2 ln(2 D/b) + 1 (docs/edges.md)."""
    given = case(defect=SLOT, contact={"damping": CHI, "stiffness": "johnson"})
    excitation = assemble.model(given).defects.excitation
    R_w, R_o = 0.006, 0.0385
    b = 2.0 * np.sqrt(excitation.scaled_load * R_w * R_o / (R_o - R_w))
    Lambda = 2.0 * np.log(4.0 * np.sqrt(R_w * R_o) / np.e / b) + 1.0
    assert excitation.exponent == pytest.approx(Lambda / (Lambda - 1.0), rel=1e-5)
    assert excitation.exponent == pytest.approx(1.070, abs=1e-3)


def test_explicit_and_default_edge_radius_may_be_combined() -> None:
    pair = [SLOT, SLOT | {"angle": "20 deg", "edge": {"radius": "20 um"}}]
    assert len(case(defects=pair).defects) == 2


@pytest.mark.usefixtures("constant_candidates")
def test_material_is_part_of_the_case_id() -> None:
    soft = case(defect=SLOT).bearing.material.model_copy(update={"young_modulus": 100e9})
    softer = case(defect=SLOT, bearing=case().bearing.model_copy(update={"material": soft}))
    assert case_id(softer) != case_id(case(defect=SLOT))


def test_elastic_edge_reduces_the_peak_force() -> None:
    short = {"duration": "50 ms", "settle": "20 ms", "defect": SLOT}
    elastic, rigid = (simulate(case(excitation=word, **short)).features for word in ("elastic-edge", "envelope"))
    assert elastic["velocity@BPFO"] == pytest.approx(1.025 * rigid["velocity@BPFO"], rel=0.01)
    assert elastic["outer_force.max"] == pytest.approx(0.80 * rigid["outer_force.max"], rel=0.02)


@pytest.mark.slow
def test_implicit_method_with_elastic_edge() -> None:
    """A heavy dashpot requires an implicit method (derivatives along the defect: test_planar_derivatives)."""
    dashpot = {"law": "general", "coefficient": 1e6, "indentation_exponent": 1.0}
    short = {"duration": "7 ms", "settle": "1 ms", "defect": SLOT}
    result = simulate(case(contact={"damping": dashpot}, **short))
    assert result.info["method"] == "rodas"
    assert result.info["crossings"] == 2
    assert np.isfinite(result.velocity).all()


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"defect": SLOT | {"edge": {"ramp": "20 um"}}}, "rounded edges only"),
        ({"defect": SLOT | {"shape": "elliptical"}}, "`elastic-edge` is not defined for an elliptical defect"),
        ({"defects": [SLOT, SLOT | {"angle": "20 deg", "edge": {"radius": "5 um"}}]}, "the same edge radius"),
        ({"defect": SLOT | {"length": "2 mm"}, "bearing": "6205"}, "which balls do not have"),
        ({"defect": SLOT, "model": "static"}, "changes the contact force"),
    ],
)
def test_unsupported_cases_are_rejected(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        case(**fields)
