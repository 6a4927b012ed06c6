"""The CPU clock of a job: what it counts, what it does not, and that it ends a job."""

import pickle
from math import inf
from time import thread_time

import pytest

from bearingsim import cpu_time


def spin(seconds: float) -> None:
    """Use CPU time."""
    end = thread_time() + seconds
    while thread_time() < end:
        pass


def test_a_job_ends_when_its_time_is_over() -> None:
    with cpu_time.at_most(0.02):
        cpu_time.check()
        spin(0.03)
        with pytest.raises(cpu_time.OutOfCpuTime, match=r"limit of 0\.02 s of CPU time.*larger `--max-cpu`"):
            cpu_time.check()
    cpu_time.check()  # the bound ends with the job
    assert cpu_time.end() == inf


def test_time_spent_before_counts_and_is_not_reported_as_the_limit() -> None:
    with cpu_time.at_most(5.0, spent=5.0), pytest.raises(cpu_time.OutOfCpuTime, match="limit of 5 s"):
        cpu_time.check()


def test_uncharged_time_does_not_count() -> None:
    with cpu_time.at_most(0.02):
        start, end = cpu_time.now(), cpu_time.end()
        with cpu_time.uncharged():
            spin(0.03)
            with cpu_time.uncharged():  # as a function that is compiled for another
                spin(0.03)
        cpu_time.check()
        assert cpu_time.now() - start < 0.01
        assert cpu_time.end() - end == pytest.approx(0.06, abs=0.01)


def test_compiled_code_receives_its_deadline_in_thread_time() -> None:
    with cpu_time.at_most(1.0):
        limit = cpu_time.bounded(lambda end: end)
        assert 0.9 < limit - thread_time() <= 1.0
    assert cpu_time.bounded(lambda end: end) == inf


def test_a_function_that_was_compiled_meanwhile_is_called_again() -> None:
    ends: list[float] = []

    def compile_first(end: float) -> str:
        ends.append(end)
        if len(ends) == 1:
            with cpu_time.uncharged():
                spin(0.03)
        return "ended" if thread_time() > end else "whole"

    with cpu_time.at_most(0.02):
        assert cpu_time.bounded(compile_first) == "whole"
    assert len(ends) == 2
    assert ends[1] - ends[0] == pytest.approx(0.03, abs=0.01)


def test_the_result_of_a_function_that_ended_early_is_not_used() -> None:
    with cpu_time.at_most(0.01), pytest.raises(cpu_time.OutOfCpuTime):
        cpu_time.bounded(lambda end: spin(0.02))


def test_the_error_reaches_another_process_whole() -> None:
    error = cpu_time.OutOfCpuTime("it took long", "take less")
    copy = pickle.loads(pickle.dumps(error))
    assert (copy.reason, copy.advice) == (error.reason, error.advice)
