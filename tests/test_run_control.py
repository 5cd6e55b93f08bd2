# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The control of a running relaxation: what is shown, when it waits, and when it ends."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.run_control import RunControl, RunStopped, Snapshot

SAFETY = 60.0  # Time after which a test that blocks fails [s]; a test that passes waits for a much shorter time.


class Counting:
    """A relaxation that counts, in its own thread."""

    def __init__(self, control: RunControl[int], steps: int) -> None:
        self.count, self.written, self.asides = 0, [0], 0
        self.control, self.steps, self.stopped = control, steps, False
        self.thread = threading.Thread(target=self.work, daemon=True)
        self.thread.start()

    def work(self) -> None:
        try:
            self.note()
            while self.count < self.steps:
                self.count += 1
                self.note()
        except RunStopped:
            self.stopped = True

    def note(self) -> None:
        def snapshot() -> Snapshot[int]:
            return Snapshot(self.count, iteration=self.count, residual=1.0, tolerance=0.1, seconds=0.0)

        self.control.after_step(snapshot, before_wait=lambda: self.written.append(self.count), aside=self.aside)

    @contextmanager
    def aside(self) -> Iterator[None]:
        self.asides += 1
        yield

    def ends(self) -> bool:
        self.thread.join(SAFETY)
        return not self.thread.is_alive()


class Watcher:
    """Collects what is shown, and waits for a count."""

    def __init__(self) -> None:
        self.seen: list[int] = []
        self.condition = threading.Condition()

    def __call__(self, snapshot: Snapshot[int]) -> None:
        with self.condition:
            self.seen.append(snapshot.state)
            self.condition.notify_all()

    def wait_for(self, count: int) -> bool:
        with self.condition:
            return self.condition.wait_for(lambda: count in self.seen, SAFETY)


def test_the_first_state_is_shown_and_then_none_before_its_time() -> None:
    watch = Watcher()
    run = Counting(RunControl(watch, seconds=1e9), 5)
    assert run.ends() and run.count == 5
    assert watch.seen == [0]


def test_a_relaxation_that_begins_paused_makes_exactly_the_steps_that_are_asked_for() -> None:
    watch = Watcher()
    control = RunControl(watch, seconds=1e9, paused=True)
    run = Counting(control, 10)
    assert watch.wait_for(0) and run.count == 0
    control.step()
    assert watch.wait_for(1)
    control.step(3)
    assert watch.wait_for(4) and control.paused
    assert watch.seen == [0, 1, 4]  # a pause shows its state whatever the time
    control.resume()
    assert run.ends() and run.count == 10 and not run.stopped


def test_a_relaxation_that_is_stopped_ends_after_its_step_also_while_it_is_paused() -> None:
    watch = Watcher()
    control = RunControl(watch, paused=True)
    run = Counting(control, 10)
    assert watch.wait_for(0)
    control.stop()
    assert run.ends() and run.stopped and run.count == 0 and control.stopped


def test_before_it_waits_a_relaxation_writes_its_state_and_a_pause_is_counted() -> None:
    watch = Watcher()
    control = RunControl(watch, paused=True)
    run = Counting(control, 4)
    assert watch.wait_for(0)
    threading.Event().wait(0.01)
    control.step(2)
    assert watch.wait_for(2)
    control.resume()
    assert run.ends()
    assert run.written == [0, 0, 2] and run.asides == 5 and control.seconds_waited >= 0.01


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: RunControl(seconds=float("nan")), "seconds between two snapshots: got nan"),
        (lambda: RunControl().step(0), "steps: got 0; expected at least 1"),
    ],
)
def test_bad_numbers_are_refused(call: Callable[[], object], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        call()
