# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The processes that do the tasks of a sweep, by Dask: some of this machine, or those of a standing scheduler.

Everything that is started here listens on the loopback address only. Dask moves tasks between its processes by pickle,
so whoever reaches a scheduler can run any code on its workers: a standing scheduler belongs into a closed network.

A worker of a GPU offers the resource ``GPU`` once, so that it gets one task at a time, and sees one device only.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from stitchmesh.compute.threads import VARIABLE as THREADS
from stitchmesh.compute.threads import core_count
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.jobs.sweep.result_table import REMEDY

if TYPE_CHECKING:
    from distributed import Client

LOOPBACK = "127.0.0.1"
GPU = "GPU"
"""Resource of a worker that has a GPU."""
QUIET = "DASK_LOGGING__DISTRIBUTED"
"""Variable with the least severity of the messages of a process of Dask."""
CONNECT_SECONDS = 30
"""Longest time to reach a scheduler [s]."""
SETTINGS = {
    "distributed.comm.timeouts.connect": CONNECT_SECONDS,
    "distributed.scheduler.allowed-failures": 2,
    "distributed.worker.daemon": True,
}
"""Settings of Dask for the processes of this machine. A task that three workers died of is not tried again."""


def import_dask() -> None:
    """Import the package of Dask that starts processes.

    Raises:
        ParameterError: it is not installed.
    """
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise ParameterError(f"sweeps: the package distributed is missing; {REMEDY}, or give --workers 0") from error
    talk = logging.getLogger("distributed")  # It reports each connection; what users have to know is an error here.
    talk.setLevel(logging.CRITICAL)
    talk.propagate = False


@contextmanager
def local_workers(count: int, gpus: int) -> Iterator[Client]:
    """Start processes on this machine and a scheduler for them; they end with the block.

    Args:
        count: number of processes that work on the CPU; they share its cores.
        gpus: number of processes that work on a GPU, one for each device, in the place of those on the CPU.

    Raises:
        ParameterError: Dask is not installed.
    """
    import_dask()
    import dask
    from distributed import Client, Nanny, Scheduler, SpecCluster

    threads = max(core_count() // max(gpus or count, 1), 1)
    places: list[Mapping[str, str]] = [{"CUDA_VISIBLE_DEVICES": str(k)} for k in range(gpus)] or [{}] * count
    common = {"host": LOOPBACK, "nthreads": 1, "dashboard": False, "silence_logs": logging.CRITICAL}
    workers = {
        k: {"cls": Nanny, "options": common | {
            "env": {THREADS: str(threads), "OPENBLAS_NUM_THREADS": "1", QUIET: "critical", **own},
            "resources": {GPU: 1.0} if own else {}, "memory_limit": _memory_of_each(len(places)),
        }}
        for k, own in enumerate(places)
    }  # fmt: skip
    places_of_scheduler = {"host": LOOPBACK, "port": 0, "dashboard": False, "dashboard_address": f"{LOOPBACK}:0"}
    scheduler = {"cls": Scheduler, "options": places_of_scheduler}
    with dask.config.set(SETTINGS):
        with (
            SpecCluster(workers=workers, scheduler=scheduler, silence_logs=logging.CRITICAL) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            yield client


@contextmanager
def standing_workers(address: str) -> Iterator[Client]:
    """Connect to a scheduler that somebody else has started; it goes on after the block.

    Args:
        address: address of the scheduler, such as ``tcp://10.0.0.5:8786``.

    Raises:
        FileError: the scheduler does not answer.
        ParameterError: Dask is not installed, or the address is none.
    """
    import_dask()
    import dask
    from distributed import Client

    with dask.config.set(SETTINGS):
        try:
            client = Client(address, set_as_default=False, timeout=CONNECT_SECONDS)
        except (OSError, ValueError) as error:
            raise FileError(f"{address}: no scheduler answers ({error}); start one by `dask scheduler`") from error
        with client:
            yield client


def offers_gpu(client: Client) -> bool:
    """Return whether a worker of a scheduler has a GPU."""
    found: Mapping[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    return any(one["resources"].get(GPU, 0) >= 1 for one in found.values())


def _memory_of_each(count: int) -> int:
    """Return the memory that each of some processes may use [bytes]; one that uses more is ended."""
    from distributed.system import MEMORY_LIMIT

    return int(MEMORY_LIMIT) // max(count, 1)
