from __future__ import annotations

import threading
import time

import pytest

from app.core.progress import Progress
from app.services.jobs import Job, JobQueue


class Log:
    def __init__(self) -> None:
        self.lines: list[tuple[str, str]] = []
        self.over = threading.Event()

    def __call__(self, job: Job) -> None:
        self.lines.append((job.title, job.state))
        if job.over:
            self.over.set()


@pytest.fixture
def log() -> Log:
    return Log()


@pytest.fixture
def jobs(log: Log):
    jobs = JobQueue(log)
    yield jobs
    jobs.close()
    assert not jobs._thread.is_alive()


def wait(log: Log) -> None:
    assert log.over.wait(5)
    log.over.clear()


def test_a_result_comes_back_with_progress(jobs: JobQueue, log: Log) -> None:
    def work(progress: Progress) -> int:
        progress.report(0.5, "half")
        return 42

    job = jobs.submit("answer", work)
    wait(log)
    assert (job.state, job.result, job.text) == ("done", 42, "half")


def test_an_error_is_kept_and_the_next_job_runs(jobs: JobQueue, log: Log) -> None:
    failed = jobs.submit("bad", lambda _: 1 / 0)
    wait(log)
    fine = jobs.submit("good", lambda _: "fine")
    wait(log)
    assert isinstance(failed.error, ZeroDivisionError)
    assert fine.result == "fine"


def test_cancel_ends_a_job_within_half_a_second(jobs: JobQueue, log: Log) -> None:
    def work(progress: Progress) -> None:
        while True:
            time.sleep(0.01)
            progress.report(0.5)

    job = jobs.submit("endless", work)
    time.sleep(0.1)
    start = time.monotonic()
    job.cancel()
    wait(log)
    assert job.state == "cancelled"
    assert time.monotonic() - start < 0.5


def test_a_waiting_job_that_is_cancelled_never_starts(jobs: JobQueue, log: Log) -> None:
    release = threading.Event()
    ran = []
    jobs.submit("first", lambda _: release.wait(5))
    second = jobs.submit("second", lambda _: ran.append(1))
    second.cancel()
    release.set()
    wait(log)
    while not second.over:
        time.sleep(0.01)
    assert second.state == "cancelled"
    assert not ran


def test_time_left_is_estimated_from_progress() -> None:
    job = Job("x", lambda _: None)
    assert job.seconds_left is None
    job.state, job.fraction, job.started = "running", 0.5, time.monotonic() - 2.0
    assert job.seconds_left == pytest.approx(2.0, rel=0.2)
