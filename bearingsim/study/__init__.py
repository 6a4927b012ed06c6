"""Study files: reading, validation, and expansion into jobs."""

from bearingsim.study.design import Design
from bearingsim.study.figures import Figure, plotted_features, restore_figure
from bearingsim.study.jobs import Job, Study, case_id, healthy_case
from bearingsim.study.load import Outline, load_study, read_outline
from bearingsim.study.paths import dimension
from bearingsim.study.rolling_parts import load_rolling_parts
from bearingsim.study.schema import json_schema, schema_text
from bearingsim.study.template import NEW_STUDY, SCHEMA_COMMENT, SCHEMA_FILE
from bearingsim.text.yamlfile import Problem, StudyError

__all__ = [
    "NEW_STUDY",
    "SCHEMA_COMMENT",
    "SCHEMA_FILE",
    "Design",
    "Figure",
    "Job",
    "Outline",
    "Problem",
    "Study",
    "StudyError",
    "case_id",
    "dimension",
    "healthy_case",
    "json_schema",
    "load_rolling_parts",
    "load_study",
    "plotted_features",
    "read_outline",
    "restore_figure",
    "schema_text",
]
