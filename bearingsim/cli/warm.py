"""`bearingsim warm`: compiles the solver before the first run that needs it."""

from pathlib import Path

from bearingsim.text.patience import Patience

DEFAULT_MODELS = ("ring", "rollers", "reference", "planar")
"""Models that a study names most; `reference` is that of a study with an accuracy."""
DEFECT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
CASE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "defects": [DEFECT]}


def compile_solver(study: Path | None, patience: Patience) -> str:
    """Compile what the cases of a study need, or the default models; return what is compiled, in words.

    Raises StudyError.
    """
    from bearingsim.config import Case
    from bearingsim.runner.progress import compiling
    from bearingsim.simulation import warm
    from bearingsim.study import load_study

    if study is not None:
        loaded = load_study(study)
        warm(loaded.cases(), compiling(patience))
        return f"the models of {loaded.name}"
    warm([Case.model_validate(CASE | {"model": model}) for model in DEFAULT_MODELS], compiling(patience))
    return ", ".join(f"`{model}`" for model in DEFAULT_MODELS)
