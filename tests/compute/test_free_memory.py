# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Memory that is free for a process: the least of machine, control groups and limit on the address space."""

from __future__ import annotations

import math
import resource
import subprocess
import sys

import pytest

from stitchmesh.compute.free_memory import host_memory
from tests.gallery import ROOT


@pytest.fixture
def system(tmp_path):
    """Return a function that makes folders of a system with 8 GB free: files by name to their text."""

    def make(files):
        texts = {"proc/meminfo": "MemTotal: 16000000 kB\nMemAvailable: 7812500 kB\n", **files}
        for name, text in texts.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text)
        return host_memory(tmp_path / "proc", tmp_path / "groups")

    return make


VERSION_2 = {
    "proc/self/cgroup": "0::/slurm/job_7\n",
    "groups/slurm/job_7/memory.max": "max\n",
    "groups/slurm/job_7/memory.current": "500000000\n",
    "groups/slurm/job_7/memory.stat": "anon 500000000\ninactive_file 0\n",
    "groups/slurm/memory.max": "2000000000\n",
    "groups/slurm/memory.current": "1500000000\n",
    "groups/slurm/memory.stat": "anon 1100000000\ninactive_file 400000000\n",
}
"""A group without a limit in a group of 2 GB, of which 1.5 GB are used, 0.4 GB of them by files that may go."""
VERSION_1 = {
    "proc/self/cgroup": "5:cpu:/\n4:memory:/docker/a\n0::/\n",
    "groups/memory/docker/a/memory.limit_in_bytes": "3000000000\n",
    "groups/memory/docker/a/memory.usage_in_bytes": "1000000000\n",
    "groups/memory/docker/a/memory.stat": "total_inactive_file 100000000\n",
    "groups/memory/memory.limit_in_bytes": "9223372036854771712\n",
    "groups/memory/memory.usage_in_bytes": "1000000000\n",
    "groups/memory/memory.stat": "total_inactive_file 0\n",
}


@pytest.mark.parametrize(
    "files, free",
    [
        ({}, 8e9),
        (VERSION_2, 0.9e9),
        (VERSION_1, 2.1e9),
        (VERSION_2 | {"groups/slurm/memory.max": "64000000000\n"}, 8e9),  # a limit above what the machine has
        (VERSION_2 | {"groups/slurm/memory.current": "2600000000\n"}, 0.0),
        # in a container the path is that outside it, and the limit is that of the folder itself
        ({"proc/self/cgroup": "0::/outside\n", "groups/memory.max": "1000000000\n", "groups/memory.current": "0\n",
          "groups/memory.stat": ""}, 1e9),
        (VERSION_2 | {"groups/slurm/memory.max": "damaged\n"}, 8e9),
    ],
)  # fmt: skip
def test_the_least_limit_of_the_groups_around_a_process_counts(system, files, free):
    assert system(files) == free


def test_a_machine_that_says_nothing_has_its_physical_memory(tmp_path):
    assert 0.0 < host_memory(tmp_path, tmp_path) < math.inf


def test_the_limit_on_the_address_space_counts():
    """The process has less left than the limit, by the address space that it uses already."""
    most = 4_000_000_000
    code = "from stitchmesh.compute.free_memory import host_memory; print(host_memory())"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (most, most)),
    )  # fmt: skip
    assert 0.0 < float(done.stdout) < most
