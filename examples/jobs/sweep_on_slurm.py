# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Run a sweep on workers that SLURM starts, each in a batch job of its own.

    pip install stitchmesh[sweeps] dask-jobqueue
    python examples/jobs/sweep_on_slurm.py examples/sweeps/tightness.toml /shared/tightness 16

The arguments are the sweep, a folder that all machines see under this path, and the number of workers. Run the script
on a machine from which jobs may be submitted, for example in tmux; run it again to continue a sweep that was
interrupted. The scheduler listens in the network of the cluster, and speaks only to those with the certificate of this
run. The workers read it in files beside the folder of the sweep that only you may read, and that end with the run.
"""

from __future__ import annotations

import sys
from pathlib import Path

from distributed import SpecCluster

from stitchmesh.jobs.sweep.closed_servers import ClosedScheduler
from stitchmesh.jobs.sweep.run_sweep import FinishedSweep, run_sweep
from stitchmesh.jobs.sweep.sweep import read_sweep


def slurm_cluster(shared: Path, *, gpus: bool = False) -> SpecCluster:
    """Return a scheduler in this process whose workers are batch jobs, with a GPU or with four cores each.

    The folder ``shared`` is one that all machines see; it gets the certificate.
    """
    from dask_jobqueue import SLURMCluster

    # Workers end in time, one after another, and are replaced; a garment continues from its checkpoint.
    lifetime = ["--lifetime", "3h40m", "--lifetime-stagger", "10m"]
    return SLURMCluster(
        security=True,
        shared_temp_directory=str(shared),
        scheduler_cls=ClosedScheduler,
        scheduler_options={"dashboard": False},
        cores=1,  # One task at a time: a task uses all cores of its worker.
        processes=1,
        job_cpu=4,
        memory="8GB",
        walltime="04:00:00",
        job_script_prologue=["export STITCHMESH_THREADS=4 OPENBLAS_NUM_THREADS=1"],
        job_extra_directives=["--gres=gpu:1"] if gpus else [],
        worker_extra_args=[*lifetime, *(["--resources", "GPU=1"] if gpus else [])],
    )


def run_on(cluster: SpecCluster, workers: int, sweep: Path, folder: Path) -> FinishedSweep:
    """Run a sweep on a number of workers of a cluster; one that ends is replaced."""
    with cluster:
        cluster.adapt(minimum=workers, maximum=workers)
        return run_sweep(read_sweep(sweep), folder, scheduler=cluster)


if __name__ == "__main__":
    target = Path(sys.argv[2])
    print(run_on(slurm_cluster(target.parent), int(sys.argv[3]), Path(sys.argv[1]), target))
