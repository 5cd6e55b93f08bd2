# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How many threads share the launches of kernels on a CPU.

Results do not depend on the number of threads. The number is the argument of ``set_threads``, else the value of the
environment variable ``STITCHMESH_THREADS``, else the number of cores that the process may use.
"""

from __future__ import annotations

import logging
import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from stitchmesh.errors import ParameterError

VARIABLE = "STITCHMESH_THREADS"
"""Environment variable with the number of threads."""
QUOTA_FILE = Path("/sys/fs/cgroup/cpu.max")
"""On Linux: processor time that a container may use in a period, or ``max``, and the period [microseconds]."""

logger = logging.getLogger(__name__)


@dataclass
class _Choice:
    """The chosen number of threads; None until it is first needed."""

    threads: int | None = None


_choice = _Choice()


def thread_count() -> int:
    """Number of threads that share a launch on a CPU.

    Raises:
        ParameterError: the environment variable is not a whole number of at least 1.
    """
    if _choice.threads is None:
        given = os.environ.get(VARIABLE)
        _choice.threads = _checked(given, VARIABLE) if given else core_count()
    return _choice.threads


def set_threads(threads: int | None) -> None:
    """Set how many threads share the launches on a CPU, for all later calls in this process.

    If the number is larger than the number of cores, the number of cores is taken and a warning says so.

    Args:
        threads: number of threads; None returns to the environment variable, or to all cores.

    Raises:
        ParameterError: the number is not a whole number of at least 1.
    """
    _choice.threads = None if threads is None else _checked(threads, "threads")


def core_count() -> int:
    """Number of cores that the affinity of this process and its container let it use."""
    if hasattr(os, "sched_getaffinity"):
        cores = len(os.sched_getaffinity(0))
    else:
        cores = os.cpu_count() or 1
    with suppress(OSError, ValueError):  # Not Linux, or no quota.
        time, period = QUOTA_FILE.read_text().split()
        cores = min(cores, max(round(int(time) / int(period)), 1))
    return cores


def _checked(threads: int | str, name: str) -> int:
    """Return a number of threads, or the number of cores if it is larger."""
    number = 0
    with suppress(ValueError):
        number = int(threads)
    if number < 1 or str(number) != str(threads):
        raise ParameterError(f"{name}: got {threads!r}; expected a whole number of at least 1")
    cores = core_count()
    if number > cores:
        logger.warning("%s: got %d, but this process may use %d cores; %d are taken", name, number, cores, cores)
    return min(number, cores)
