# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A script that a worker loads first: jobs are short, and some of them harm their process.

The tightness of a job says what it does: 1.25 kills its process, 1.5 takes memory without end, 1.75 finds a full disk
as long as the file ``full`` is in the folder of the sweep, and all other jobs end at once with their tightness as a
measure. Each begun task is noted in ``begun.txt``.
"""

from __future__ import annotations

import errno
import os
import signal
import time
from pathlib import Path

from stitchmesh.errors import FileError
from stitchmesh.jobs.sweep import work
from stitchmesh.jobs.sweep.row import ERROR, inputs_of

KILLS, SWALLOWS, FILLS = 1.25, 1.5, 1.75


def short_work(task, folder):
    with (folder / "begun.txt").open("a") as file:
        file.write(f"{task.key}\n")
    for gamma in (one.job.swatch.gamma for one in task.jobs):
        if gamma == KILLS:
            os.kill(os.getpid(), signal.SIGKILL)
        if gamma == SWALLOWS:
            swallow()
        if gamma == FILLS and (folder / "full").exists():
            raise FileError(f"{folder}: cannot be written") from OSError(errno.ENOSPC, "No space left on device")
        while (folder / "hold").exists():
            time.sleep(0.02)
    return {
        one.key: inputs_of(one.job) | {ERROR: None, "measure": one.job.swatch.gamma, "job_seconds": 0.0, "worker": "w"}
        for one in task.jobs
    }


def swallow():
    """Take memory until the process is ended."""
    taken = []
    while True:
        taken.append(bytearray(os.urandom(1 << 20) * 16))
        time.sleep(0.02)


def dask_setup(_worker):
    work._swatches = lambda task, folder: short_work(task, Path(folder))
