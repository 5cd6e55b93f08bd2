# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxations of yarns that are watched, paused, stepped and stopped."""

from __future__ import annotations

import logging
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.device import alone
from stitchmesh.quality import PRESETS
from stitchmesh.run import Checkpoints, Run
from stitchmesh.run_control import RunControl, Snapshot
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import Relaxation, relax_yarns
from tests.yarnrelax.stockinette import tube

SAFETY = 120.0  # Time after which a test that blocks fails [s]; a test that passes waits for a much shorter time.
SHORT = replace(PRESETS["draft"], tolerance=1e-9, max_iterations=80)


def relaxed(**options: Any) -> Relaxation:
    return relax_yarns(tube(4, 6), **{"quality": SHORT, "device": "cpu"} | options)


@pytest.fixture(scope="module")
def plain() -> Relaxation:
    return relaxed()


class Live:
    """A relaxation in a thread of its own, whose pauses the test waits for."""

    def __init__(self, checkpoints: Checkpoints | None = None) -> None:
        self.shown: list[Snapshot[YarnSet]] = []
        self.result: Relaxation | None = None
        self.condition = threading.Condition()
        self.control = RunControl(self.watch, seconds=0.0, paused=True)
        self.thread = threading.Thread(target=self.work, args=[checkpoints], daemon=True)
        self.thread.start()

    def watch(self, snapshot: Snapshot[YarnSet]) -> None:
        with self.condition:
            self.shown.append(snapshot)
            self.condition.notify_all()

    def work(self, checkpoints: Checkpoints | None) -> None:
        self.result = relaxed(run=Run(checkpoints=checkpoints, control=self.control))

    def wait_for(self, iteration: int) -> Snapshot[YarnSet]:
        with self.condition:
            assert self.condition.wait_for(lambda: self.shown and self.shown[-1].iteration == iteration, SAFETY)
            return self.shown[-1]

    def end(self) -> Relaxation:
        self.thread.join(SAFETY)
        assert self.result is not None
        return self.result


def test_a_relaxation_in_steps_has_the_bits_of_one_without(plain: Relaxation) -> None:
    live = Live()
    for iteration in (0, 20, 40):
        live.wait_for(iteration)
        live.control.step()
    live.wait_for(60)
    live.control.resume()
    result = live.end()
    assert np.array_equal(result.yarns.points, plain.yarns.points)
    assert result.report["iterations"] == 80 and not result.report["stopped"]


def test_a_stopped_relaxation_returns_its_last_good_state_without_a_warning(caplog: pytest.LogCaptureFixture) -> None:
    live = Live()
    live.control.step()
    shown = live.wait_for(20)
    live.control.stop()
    result = live.end()
    assert np.array_equal(result.yarns.points, shown.state.points)
    assert result.report["stopped"] and not result.report["converged"] and result.report["iterations"] == 20
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING]


def test_a_pause_writes_a_checkpoint_from_which_another_process_could_continue(tmp_path: Path, plain: Relaxation):
    checkpoint = Checkpoints(tmp_path, every=1_000_000)
    live = Live(checkpoint)
    live.control.step(2)
    live.wait_for(40)
    with alone():  # The paused relaxation gives its access up, after it has written its checkpoint.
        resumed = relaxed(run=Run(resume=checkpoint.path))
    live.control.stop()
    live.end()
    assert np.array_equal(resumed.yarns.points, plain.yarns.points)
