"""`bearingsim warm`: compiles the solver in advance."""

from pathlib import Path

from bearingsim.text.announcer import Announcer

DEFECT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
CASE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "defects": [DEFECT]}


def compile_solver(study: Path | None, announcements: Announcer) -> str:
    """Compile the solver for the cases of a study; return their models, in words.

    Without a study, compile the default model and the reference of most studies with an accuracy, both with and
    without friction. Raises StudyError.
    """
    from bearingsim.catalogue import DEFAULT_MODEL, REFERENCE
    from bearingsim.config import Case
    from bearingsim.runner.progress import compilation_callback
    from bearingsim.selection.candidates import with_friction
    from bearingsim.simulation import warm
    from bearingsim.study import load_study

    if study is not None:
        cases = load_study(study).cases()
    else:
        default_case, reference = (
            Case.model_validate(CASE | {"model": model}) for model in (DEFAULT_MODEL, REFERENCE)
        )
        cases = [default_case, reference, with_friction(reference) or reference]
    warm(cases, compilation_callback(announcements))
    return ", ".join(f"`{model}`" for model in dict.fromkeys(case.model for case in cases))
