"""Studies of designs, and their values by row."""

from bearingsim.study import Design, Study, case_id
from tests.scenes.study_text import BASE

OVER = "{defect.width: [0.2 mm, 2 mm], load: {log: [50 N, 500 N]}}"


def sweep(kind: str = "sobol", n: int = 16, over: str = OVER, more: str = "") -> str:
    return f"{BASE}sweep: {{{kind}: {{n: {n}, seed: 1, over: {over}}}{more}}}\n"


def design_of(study: Study) -> Design:
    assert study.design is not None
    return study.design


def values(study: Study, path: str) -> list[float]:
    """Values of a path in each row of a design."""
    swept = {case_id(case): values for case, values in study.swept_cases}
    return [float(swept[name][path]) for name in design_of(study).ids]
