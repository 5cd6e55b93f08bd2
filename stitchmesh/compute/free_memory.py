# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The memory of a device that is free for this process, and the most memory that the process has had.

The free memory of the host is the least of three amounts: the free memory of the machine, the memory that the control
groups of the process still allow (containers and the schedulers of clusters limit the memory by them, in version 1 or
2), and the rest of the limit on its address space (``ulimit -v``). Control groups count cached files as used memory.
The system drops cached files that nobody has read lately as soon as memory is needed, so they count as free here.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import warp as wp

try:
    import resource
except ImportError:  # Windows has no such limits.
    resource = None  # type: ignore[assignment]

PROC, CONTROL_GROUPS = Path("/proc"), Path("/sys/fs/cgroup")
"""Where Linux shows the machine with its processes, and where it shows the control groups."""
FILES_OF_VERSION = {1: ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
                    2: ("memory.max", "memory.current", "inactive_file")}  # fmt: skip
"""File of the limit and of the use of a control group, and the entry of ``memory.stat`` for files unread lately."""


def available_memory(device: wp.Device) -> float:
    """Return the memory that is free on a device [bytes]."""
    return float(device.free_memory) if device.is_cuda else host_memory()


def host_memory(proc: Path = PROC, control_groups: Path = CONTROL_GROUPS) -> float:
    """Return the memory of the host that is free for this process [bytes].

    Args:
        proc: folder in which the system shows the machine and its processes.
        control_groups: folder in which the system shows the control groups.
    """
    return min(_machine_memory(proc), _group_memory(proc, control_groups), _address_space(proc))


def forget_peak_memory() -> None:
    """Let ``peak_memory`` count from now on; on systems other than Linux it counts from the start of the process."""
    with suppress(OSError):
        (PROC / "self" / "clear_refs").write_text("5", encoding="ascii")  # 5 is the word for the peak


def peak_memory() -> int:
    """Return the largest memory of the host that this process has had [bytes]; 0 on systems that do not say it."""
    with suppress(OSError, ValueError):
        lines = (PROC / "self" / "status").read_text("ascii").splitlines()
        return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:"))
    return 0 if resource is None else 1024 * int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


def _machine_memory(proc: Path) -> float:
    """Return the free memory of the machine [bytes]."""
    try:
        lines = dict(line.split(":", 1) for line in (proc / "meminfo").read_text("ascii").splitlines())
        return 1024.0 * float(lines["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError):
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))


def _group_memory(proc: Path, control_groups: Path) -> float:
    """Return the least memory that a control group of the process still allows [bytes]; infinite without a limit."""
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
    """Yield the folder of a control group and the folders around it; in a container some of them may not exist."""
    own = root / path.strip("/")
    yield from (group for group in (own, *own.parents) if group == root or root in group.parents)


def _left_in(group: Path, version: int) -> float:
    """Return the memory that one control group still allows [bytes]; infinite if it has no limit."""
    limit, used, unread = FILES_OF_VERSION[version]
    try:
        most, now = (group / limit).read_text("ascii").strip(), float((group / used).read_text("ascii"))
        entries = dict(line.split() for line in (group / "memory.stat").read_text("ascii").splitlines())
        return math.inf if most == "max" else max(float(most) - now + float(entries.get(unread, 0)), 0.0)
    except (OSError, ValueError):
        return math.inf


def _address_space(proc: Path) -> float:
    """Return the rest of the limit on the address space of the process [bytes]; infinite without a limit."""
    most = -1 if resource is None else resource.getrlimit(resource.RLIMIT_AS)[0]
    if most == -1:
        return math.inf
    try:
        pages = int((proc / "self" / "statm").read_text("ascii").split()[0])
    except (OSError, ValueError, IndexError):
        pages = 0
    return max(float(most - pages * os.sysconf("SC_PAGE_SIZE")), 0.0)
