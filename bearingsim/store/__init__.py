"""Results folder of a study: immutable unit files, journals, failures, and a table made from them.

Files are written completely before they get their final name, and only the table has more than one writer. A run
can therefore be killed at any moment, and several runs can share a folder.
"""

from bearingsim.store.choices import (
    Choice,
    Choices,
    DamagedChoices,
    add_choices,
    read_choices,
    read_plans,
    write_choices,
)
from bearingsim.store.files import (
    DiskFull,
    LinkWithin,
    check_room,
    lock,
    refuse_links,
    room,
    sweep,
    write_bytes,
    write_text,
)
from bearingsim.store.folder import (
    FolderInUse,
    Holdings,
    claim_results,
    discard,
    holdings,
    in_use,
    refuse_users_study,
)
from bearingsim.store.journal import Failure, clear_failure, log, now, read_failures, start_marker, take_suspects
from bearingsim.store.marker import NotOurs, OtherStudy, claim
from bearingsim.store.merge import Merged, Unmergeable, merge
from bearingsim.store.names import case_of, flat_parameters
from bearingsim.store.nearness import PARTS, Audited, audited, nearness, withdrawn
from bearingsim.store.provenance import made_of, provenance
from bearingsim.store.prune import Superfluous, prune, superfluous
from bearingsim.store.results import Results, ResultsError, open_results, planned_jobs, results_folder
from bearingsim.store.scans import keep_scans, kept_scans, with_short_paths
from bearingsim.store.sealed import UNREADABLE
from bearingsim.store.spread import NOTABLE, errors, is_one_draw, relative_error, spread
from bearingsim.store.table import build_table, info, job_frame, own_frame, plan_of, read_plan, write_plan
from bearingsim.store.units import (
    DamagedUnit,
    Series,
    check_unit,
    jobs_named,
    read_series,
    sealed_units,
    take_unit,
    unit_name,
    unit_names,
    unit_path,
    write_units,
)

__all__ = [
    "NOTABLE",
    "PARTS",
    "UNREADABLE",
    "Audited",
    "Choice",
    "Choices",
    "DamagedChoices",
    "DamagedUnit",
    "DiskFull",
    "Failure",
    "FolderInUse",
    "Holdings",
    "LinkWithin",
    "Merged",
    "NotOurs",
    "OtherStudy",
    "Results",
    "ResultsError",
    "Series",
    "Superfluous",
    "Unmergeable",
    "add_choices",
    "audited",
    "build_table",
    "case_of",
    "check_room",
    "check_unit",
    "claim",
    "claim_results",
    "clear_failure",
    "discard",
    "errors",
    "flat_parameters",
    "holdings",
    "in_use",
    "info",
    "is_one_draw",
    "job_frame",
    "jobs_named",
    "keep_scans",
    "kept_scans",
    "lock",
    "log",
    "made_of",
    "merge",
    "nearness",
    "now",
    "open_results",
    "own_frame",
    "plan_of",
    "planned_jobs",
    "provenance",
    "prune",
    "read_choices",
    "read_failures",
    "read_plan",
    "read_plans",
    "read_series",
    "refuse_links",
    "refuse_users_study",
    "relative_error",
    "results_folder",
    "room",
    "sealed_units",
    "spread",
    "start_marker",
    "superfluous",
    "sweep",
    "take_suspects",
    "take_unit",
    "unit_name",
    "unit_names",
    "unit_path",
    "with_short_paths",
    "withdrawn",
    "write_bytes",
    "write_choices",
    "write_plan",
    "write_text",
    "write_units",
]
