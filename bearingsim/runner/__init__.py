"""Executing the jobs of a study: local pool, shards, quarantine of what kills its worker, progress."""

from bearingsim.runner.pool import WorkersDie
from bearingsim.runner.run import run, with_models
from bearingsim.runner.summary import FailureGroup, Interrupted, RunSummary
from bearingsim.runner.tally import finished
from bearingsim.runner.work import Engine

__all__ = ["Engine", "FailureGroup", "Interrupted", "RunSummary", "WorkersDie", "finished", "run", "with_models"]
