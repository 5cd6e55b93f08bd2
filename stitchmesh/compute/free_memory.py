# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Memory that is free on a device, for this process.

Beside the processor it is the least of three amounts: what the machine has free, what the control groups of the process
leave (containers and schedulers of clusters limit the memory by them, in version 1 or 2), and what the limit on its
address space leaves (``ulimit -v``). Control groups count files in memory as used; those that nobody has read lately
make room at once, so they count as free here.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import warp as wp

try:
    import resource
except ImportError:  # Windows has no such limits.
    resource = None  # type: ignore[assignment]

PROC, CONTROL_GROUPS = Path("/proc"), Path("/sys/fs/cgroup")
"""Where Linux shows the machine with its processes, and the control groups."""
FILES_OF_VERSION = {1: ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
                    2: ("memory.max", "memory.current", "inactive_file")}  # fmt: skip
"""Names of the limit and of the use of a control group, and the entry of its ``memory.stat`` for unread files."""


def available_memory(device: wp.Device) -> float:
    """Return the memory that is free on a device [bytes]."""
    return float(device.free_memory) if device.is_cuda else host_memory()


def host_memory(proc: Path = PROC, control_groups: Path = CONTROL_GROUPS) -> float:
    """Return the memory that is free for this process beside the processor [bytes].

    Args:
        proc: folder in which the system shows the machine and its processes.
        control_groups: folder in which the system shows the control groups.
    """
    return min(_machine_memory(proc), _group_memory(proc, control_groups), _address_space(proc))


def _machine_memory(proc: Path) -> float:
    """Return what the machine has free [bytes]."""
    try:
        lines = dict(line.split(":", 1) for line in (proc / "meminfo").read_text("ascii").splitlines())
        return 1024.0 * float(lines["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError):
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))


def _group_memory(proc: Path, control_groups: Path) -> float:
    """Return the least memory that a control group of the process leaves [bytes]; infinite without a limit."""
    try:
        lines = (proc / "self" / "cgroup").read_text("ascii").splitlines()
    except (OSError, ValueError):
        return math.inf
    left = math.inf
    for line in lines:
        _number, _, rest = line.partition(":")
        controllers, _, path = rest.partition(":")
        if controllers in ("", "memory"):
            version, root = (1, control_groups / "memory") if controllers else (2, control_groups)
            left = min([left, *(_left_in(group, version) for group in _with_groups_around(root, path))])
    return left


def _with_groups_around(root: Path, path: str) -> Iterator[Path]:
    """Yield the folder of a control group and of those around it; in a container its path may not be there."""
    own = root / path.strip("/")
    yield from (group for group in (own, *own.parents) if group == root or root in group.parents)


def _left_in(group: Path, version: int) -> float:
    """Return the memory that one control group leaves [bytes]; infinite if it has no limit."""
    limit, used, unread = FILES_OF_VERSION[version]
    try:
        most, now = (group / limit).read_text("ascii").strip(), float((group / used).read_text("ascii"))
        entries = dict(line.split() for line in (group / "memory.stat").read_text("ascii").splitlines())
        return math.inf if most == "max" else max(float(most) - now + float(entries.get(unread, 0)), 0.0)
    except (OSError, ValueError):
        return math.inf


def _address_space(proc: Path) -> float:
    """Return what the limit on the address space of the process leaves [bytes]; infinite without a limit."""
    most = -1 if resource is None else resource.getrlimit(resource.RLIMIT_AS)[0]
    if most == -1:
        return math.inf
    try:
        pages = int((proc / "self" / "statm").read_text("ascii").split()[0])
    except (OSError, ValueError, IndexError):
        pages = 0
    return max(float(most - pages * os.sysconf("SC_PAGE_SIZE")), 0.0)
