"""Results folder of a study: immutable unit files, journals, failures, and a table made from them.

Files are written completely before they get their final name, and only the table has more than one writer. A run
can therefore be killed at any moment, and several runs can share a folder.
"""

from bearingsim.errors import ResultsError
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
    LinkInFolder,
    check_free_space,
    full_disk_errors,
    lock,
    refuse_links,
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
    refuse_own_study_file,
)
from bearingsim.store.journal import Failure, clear_failure, log, now, read_failures, start_marker, take_suspects
from bearingsim.store.marker import ForeignFolder, OtherStudy, claim
from bearingsim.store.merge import MergeSummary, Unmergeable, merge
from bearingsim.store.names import case_of, flat_parameters
from bearingsim.store.nearness import ERROR_PARTS, AuditResult, audit_results, error_bounds, withdrawn_errors
from bearingsim.store.provenance import provenance, study_digest
from bearingsim.store.prune import RemovableFiles, find_removable, prune
from bearingsim.store.results import Results, open_results, planned_jobs, results_folder
from bearingsim.store.scans import read_scans, store_scans, with_short_paths
from bearingsim.store.sealed import UNREADABLE
from bearingsim.store.spread import NOTABLE_ERROR, errors, is_uncertain, relative_error, spread
from bearingsim.store.table import (
    build_table,
    info,
    job_frame,
    make_plan,
    plan_frame,
    read_plan,
    read_study_text,
    write_plan,
)
from bearingsim.store.units import (
    DamagedUnit,
    Series,
    check_unit,
    read_job_ids,
    read_provenance,
    read_series,
    sealed_units,
    store_unit,
    unit_name,
    unit_names,
    unit_path,
    write_units,
)

__all__ = [
    "ERROR_PARTS",
    "NOTABLE_ERROR",
    "UNREADABLE",
    "AuditResult",
    "Choice",
    "Choices",
    "DamagedChoices",
    "DamagedUnit",
    "DiskFull",
    "Failure",
    "FolderInUse",
    "ForeignFolder",
    "Holdings",
    "LinkInFolder",
    "MergeSummary",
    "OtherStudy",
    "RemovableFiles",
    "Results",
    "ResultsError",
    "Series",
    "Unmergeable",
    "add_choices",
    "audit_results",
    "build_table",
    "case_of",
    "check_free_space",
    "check_unit",
    "claim",
    "claim_results",
    "clear_failure",
    "discard",
    "error_bounds",
    "errors",
    "find_removable",
    "flat_parameters",
    "full_disk_errors",
    "holdings",
    "in_use",
    "info",
    "is_uncertain",
    "job_frame",
    "lock",
    "log",
    "make_plan",
    "merge",
    "now",
    "open_results",
    "plan_frame",
    "planned_jobs",
    "provenance",
    "prune",
    "read_choices",
    "read_failures",
    "read_job_ids",
    "read_plan",
    "read_plans",
    "read_provenance",
    "read_scans",
    "read_series",
    "read_study_text",
    "refuse_links",
    "refuse_own_study_file",
    "relative_error",
    "results_folder",
    "sealed_units",
    "spread",
    "start_marker",
    "store_scans",
    "store_unit",
    "study_digest",
    "sweep",
    "take_suspects",
    "unit_name",
    "unit_names",
    "unit_path",
    "with_short_paths",
    "withdrawn_errors",
    "write_bytes",
    "write_choices",
    "write_plan",
    "write_text",
    "write_units",
]
