# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Refuse files on a full disk, on a disk that is read only, and in a folder that is removed in the middle of a run.

The runs of ``works.py`` replace old files on a small ``tmpfs``, which needs root and a mount namespace of its own
(``unshare``). Each must end with status 2 and one line of error that names the reason, leave all old files whole and no
part of a file, and succeed once the disk has space again. The exit status is 1 if there is a fault.
"""

from __future__ import annotations

import logging
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Generator
from functools import partial
from pathlib import Path

from benchmarks.table import Rows
from stitchmesh.io import atomic
from stitchmesh.io.part_folder import PARTS, PartFolder
from stitchmesh.render.gl_probe import check_display
from tests.crashes.kills import checksum, files_of, in_child, status_of
from tests.crashes.works import Work, load_modules, read_file, works

FREE = (0, 8, 16, 32, 64, 128)
"""Space that is left on the disk for the new files [KiB]."""
WRITES = (0, 1, 2, 4)
"""Numbers of the writes at which the folder is removed."""
REMOVED = "No such file or directory", "was removed while it was in use"
"""What an error says of a folder that was removed."""
INSIDE = "STITCHMESH_IN_NAMESPACE"
"""Environment variable of the process that has a mount namespace of its own."""


def ended(work: Callable[[], int], said: Path) -> tuple[int, list[str]]:
    """Run a function in a child process; return its status, and the lines about errors of its standard error."""
    status = status_of(in_child(work, said))
    return status, [line for line in said.read_text().splitlines() if "Error" in line or "Traceback" in line]


def fill(disk: Path, kib: int) -> Path:
    """Fill a disk up to some space; return the file that fills it."""
    state, filler = os.statvfs(disk), disk / "filler"
    with filler.open("wb") as file:
        file.write(bytes(max(state.f_bavail * state.f_frsize - 1024 * kib, 0)))
    return filler


def mounted(disk: Path, *options: str) -> None:
    """Mount the small disk, or change its options."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", ",".join(("size=16m", *options)), "tmpfs", str(disk)], check=True)


def whole(work: Work, folder: Path, before: dict[str, str]) -> list[str]:
    """Return what is wrong with the files of a folder."""
    there = {name: checksum(folder / name) for name in files_of(folder)}
    faults = [f"{name} is missing" for name in before.keys() - there.keys()
              if not any(Path(name).match(pattern) for pattern in work.may_go)]  # fmt: skip
    for name in (name for name, value in there.items() if value != before.get(name)):
        try:
            read_file(folder / name)
        except Exception as error:
            faults.append(f"{name} is damaged: {error}")
    return faults + [f"{path} is left" for path in folder.rglob(PARTS)]


def on_a_full_disk(work: Work, old: Path, disk: Path, kib: int) -> tuple[int, list[str]]:
    """Run a work on a disk with little space; return its status and the faults."""
    folder = Path(shutil.copytree(old, disk / "out"))
    before, filler = {name: checksum(folder / name) for name in files_of(folder)}, fill(disk, kib)
    status, lines = ended(lambda: work.new(folder), old.parent / "said")
    faults = whole(work, folder, before)
    if status == 2 and not (len(lines) == 1 and "(No space left on device); free space on this disk" in lines[0]):
        faults.append(f"said {lines}")
    if status not in (0, 2):
        faults.append(f"ended with status {status}: {lines}")
    filler.unlink()
    again, lines = ended(lambda: work.new(folder), old.parent / "said")
    if again != 0:
        faults.append(f"the next run ended with status {again}: {lines}")
    faults += whole(work, folder, before)
    shutil.rmtree(folder)
    return status, faults


def on_a_read_only_disk(work: Work, old: Path, disk: Path) -> tuple[int, list[str]]:
    """Run a work in a folder of a disk that is read only; return its status and the faults."""
    folder = Path(shutil.copytree(old, disk / "out"))
    mounted(disk, "remount", "ro")
    status, lines = ended(lambda: work.new(folder), old.parent / "said")
    mounted(disk, "remount", "rw")
    shutil.rmtree(folder)
    said = len(lines) == 1 and "(Read-only file system); choose a folder that you may write" in lines[0]
    return status, [] if said and status == 2 else [f"ended with status {status}: {lines}"]


def in_a_folder_that_vanishes(work: Work, old: Path, disk: Path, number: int) -> tuple[int, list[str]]:
    """Run a work whose folder is removed before one of its writes; return its status and the faults."""
    folder, left = Path(shutil.copytree(old, disk / "out")), [number]

    class Removing(PartFolder):
        def __init__(self, beside: Path) -> None:
            super().__init__(beside)
            if left[0] == 0:
                shutil.rmtree(folder)
            left[0] -= 1

    def vanishing() -> int:
        atomic.PartFolder = Removing  # type: ignore[misc]
        return work.new(folder)

    status, lines = ended(vanishing, old.parent / "said")
    said = len(lines) == 1 and any(reason in lines[0] for reason in REMOVED)
    made_again = work.remakes and status == 0 and ended(lambda: work.new(folder), old.parent / "said")[0] == 0
    shutil.rmtree(folder, ignore_errors=True)
    return status, [] if (said and status == 2) or made_again else [f"ended with status {status}: {lines}"]


def row_of(work: Work, scratch: Path, disk: Path) -> Generator[tuple[object, ...], None, list[str]]:
    """Run a work on all disks, yield a row of the table, and return the faults."""
    old = scratch / "old"
    old.mkdir(parents=True)
    ended(lambda: work.old(old), scratch / "said")
    cases = {f"{kib} KiB": partial(on_a_full_disk, work, old, disk, kib) for kib in FREE}
    cases["read only"] = partial(on_a_read_only_disk, work, old, disk)
    cases |= {f"removed at write {n}": partial(in_a_folder_that_vanishes, work, old, disk, n) for n in WRITES}
    results = {name: case() for name, case in cases.items()}
    statuses = (status for status, _ in results.values())
    faults = [f"{work.name}, {name}: {fault}" for name, (_, found) in results.items() for fault in found]
    yield work.name, *statuses, len(faults)
    return faults


def refusals(*, only: tuple[str, ...] = ()) -> Rows:
    """Yield a table of exit statuses.

    Args:
        only: names of works; default: all
    """
    if INSIDE not in os.environ:
        os.environ[INSIDE] = "1"
        os.execvp("unshare", ["unshare", "--mount", sys.executable, "-m", "tests.crashes", *sys.argv[1:]])
    check_display()
    load_modules()
    logging.disable()
    names = [*(f"{kib} KiB free" for kib in FREE), "read only", *(f"removed at write {number}" for number in WRITES)]
    yield "run", *names, "faults"
    faults: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        scratch, disk = Path(name), Path(name) / "disk"
        (scratch / "inputs").mkdir()
        disk.mkdir()
        mounted(disk)
        for work in works(scratch / "inputs"):
            if not only or work.name in only:
                faults += yield from row_of(work, scratch / work.name, disk)
        subprocess.run(["umount", str(disk)], check=True)
    yield from faults
    return int(bool(faults))
