# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The processes of Dask that do the tasks of a sweep, on this machine or at a standing scheduler.

Dask moves tasks between its processes by pickle, so anybody who can connect to a process can run any code in it.
Processes that are started here listen on the loopback address, which other users of the machine can reach too. They
therefore accept only connections with the certificate of one sweep, which exists in the memory of its processes. A
standing scheduler has certificates of its own (``tls://``), or belongs into a closed network. A worker of a GPU offers
the resource ``GPU`` once, so that it gets one task at a time, and sees one device only.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from stitchmesh.child_interpreter import clean_children
from stitchmesh.compute.threads import VARIABLE as THREADS
from stitchmesh.compute.threads import core_count
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.jobs.sweep.result_table import REMEDY

if TYPE_CHECKING:
    from distributed import Client
    from distributed.deploy.cluster import Cluster
    from distributed.security import Security

TLS = "tls://"
"""How the address of a scheduler begins that needs a certificate."""
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
"""Settings of Dask for the processes of this machine. A task is not tried again after three workers have died during
it."""


def import_dask() -> None:
    """Import the package of Dask that starts processes.

    Raises:
        ParameterError: the package is not installed.
    """
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise ParameterError(f"sweeps: the package distributed is missing; {REMEDY}, or give --workers 0") from error
    talk = logging.getLogger("distributed")  # It reports each connection, which users need not know.
    talk.setLevel(logging.CRITICAL)
    talk.propagate = False


@contextmanager
def local_workers(count: int, gpus: int) -> Iterator[Client]:
    """Start processes on this machine and a scheduler for them; they end with the block.

    Args:
        count: number of processes that work on the CPU; they share its cores.
        gpus: number of processes that work on a GPU, one for each device; if it is not 0, no process works on the CPU.

    Raises:
        ParameterError: Dask or cryptography is not installed.
    """
    import_dask()
    import dask
    from distributed import Client, Nanny, SpecCluster

    from stitchmesh.jobs.sweep.closed_servers import ClosedScheduler, ClosedWorker

    threads = max(core_count() // max(gpus or count, 1), 1)
    places: list[Mapping[str, str]] = [{"CUDA_VISIBLE_DEVICES": str(k)} for k in range(gpus)] or [{}] * count
    common = {"host": LOOPBACK, "nthreads": 1, "silence_logs": logging.CRITICAL, "worker_class": ClosedWorker}
    security = _security_of_one_sweep()
    private = TemporaryDirectory(prefix="stitchmesh-")  # Workers unpickle data that they have stored on the disk.
    workers = {
        k: {"cls": Nanny, "options": common | {
            "security": security, "local_directory": private.name,
            "env": {THREADS: str(threads), "OPENBLAS_NUM_THREADS": "1", QUIET: "critical", **own},
            "resources": {GPU: 1.0} if own else {}, "memory_limit": _memory_of_each(len(places)),
        }}
        for k, own in enumerate(places)
    }  # fmt: skip
    of_scheduler = {"host": LOOPBACK, "port": 0, "dashboard": False, "security": security}
    scheduler = {"cls": ClosedScheduler, "options": of_scheduler}
    with (
        private,
        clean_children(),
        dask.config.set(SETTINGS),
        SpecCluster(
            workers=workers, scheduler=scheduler, security=security, silence_logs=logging.CRITICAL
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


@contextmanager
def standing_workers(scheduler: str | Cluster) -> Iterator[Client]:
    """Connect to a scheduler that somebody else has started; it goes on after the block.

    Args:
        scheduler: address of the scheduler, such as ``tls://10.0.0.5:8786``, to which this process shows the
            certificate of the configuration of Dask; or a cluster, which has a certificate of its own.

    Raises:
        FileError: the scheduler does not answer.
        ParameterError: Dask is not installed, or its configuration has no certificate for the address.
    """
    import_dask()
    import dask
    from distributed import Client

    name = address_of(scheduler)
    if scheduler is name:
        _check_certificates(name)
    with dask.config.set(SETTINGS):
        try:
            client = Client(scheduler, set_as_default=False, timeout=CONNECT_SECONDS)
        except (OSError, ValueError) as error:
            raise FileError(f"{name}: no scheduler answers ({error}); start one by `dask scheduler`") from error
        with client:
            yield client


def _check_certificates(address: str) -> None:
    """Check that the configuration of Dask suits an address; Dask itself would wait for a minute.

    Raises:
        ParameterError: the configuration has no certificate for ``tls://``, has one that cannot be read, or forbids
            ``tcp://``.
    """
    from distributed.security import Security

    remedy = "set certificates in the configuration of Dask, and give an address with tls:// (docs/how-to/sweeps.md)"
    security = Security()
    try:
        has_certificate = security.get_connection_args("client")["ssl_context"] is not None
    except OSError as error:
        raise ParameterError(f"{address}: its certificates cannot be read ({error}); {remedy}") from error
    if address.startswith(TLS) and not has_certificate:
        raise ParameterError(f"{address}: the configuration of Dask holds no certificate; {remedy}")
    if security.require_encryption and not address.startswith(TLS):
        raise ParameterError(f"{address}: the configuration of Dask requires encryption; {remedy}")


def address_of(scheduler: str | Cluster) -> str:
    """Return the address of a scheduler."""
    return scheduler if isinstance(scheduler, str) else scheduler.scheduler_address


def _security_of_one_sweep() -> Security:
    """Return a key and a certificate that exist in memory only; all processes of a sweep show them to each other.

    Raises:
        ParameterError: the package that makes certificates is not installed.
    """
    from distributed.security import Security

    try:
        return Security.temporary()
    except ImportError as error:
        raise ParameterError(f"sweeps: the package cryptography is missing; {REMEDY}, or give --workers 0") from error


def offers_gpu(client: Client) -> bool:
    """Return whether a worker of a scheduler has a GPU."""
    found: Mapping[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    return any(one["resources"].get(GPU, 0) >= 1 for one in found.values())


def _memory_of_each(count: int) -> int:
    """Return the memory that each of ``count`` processes may use [bytes]; a process that uses more is ended."""
    from distributed.system import MEMORY_LIMIT

    return int(MEMORY_LIMIT) // max(count, 1)
