# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Kill processes with SIGKILL while they write, and check that every file is the whole old one or a whole new one.

Each process replaces old files by new ones (``works.py``). It is killed at a random time within a random one of
its writes. Then each file is compared with the versions that an uninterrupted process writes, or read with its reader
if it holds times; no old file may be missing. The next run must succeed, end with the new files and leave no part of a
file. The exit status is 1 if there is a fault.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.table import Rows
from stitchmesh.io import atomic
from stitchmesh.io.own_files import RECORD
from stitchmesh.io.part_folder import PARTS, PartFolder
from stitchmesh.render.gl_probe import check_display
from tests.crashes.works import Work, load_modules, read_file, works

HIDDEN = {".lock", PARTS, RECORD}


@dataclass(frozen=True)
class Reference:
    """What an uninterrupted run writes."""

    seconds: list[float]
    """Duration of each write [s]."""
    versions: dict[str, set[str]]
    """Checksums of the contents that each file had, of files without times."""
    last: dict[str, str]
    """Checksum of the last content of each of these files."""


@dataclass
class Tally:
    """What the kills of one work left."""

    kills: int = 0
    parts: int = 0
    """Kills that left a part of a file."""
    files: Counter[str] = field(default_factory=Counter)
    """Files after the kills: old, new, or with times."""
    faults: list[str] = field(default_factory=list)


def in_child(work: Callable[[], int], said: Path = Path(os.devnull)) -> int:
    """Start a child process that runs a function and ends with the status that it returns; return its number.

    Args:
        work: the function.
        said: file of its standard error.
    """
    child = os.fork()
    if child == 0:
        status = 99
        try:
            with open(os.devnull, "w") as nowhere, said.open("w") as errors:
                os.dup2(nowhere.fileno(), 1)
                os.dup2(errors.fileno(), 2)
                status = work()
                sys.stderr.flush()
        except BaseException:
            traceback.print_exc()
        os._exit(status)
    return child


def status_of(child: int) -> int:
    """Wait for a child process; return its exit status, negative if a signal has ended it."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def checksum(path: Path) -> str:
    """Checksum of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def files_of(folder: Path) -> Iterator[str]:
    """Names of the files of a folder, without parts and locks."""
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if path.is_file() and not HIDDEN & set(name.parts):
            yield str(name)


def record(work: Work, folder: Path, notes: Path) -> int:
    """Run a work, and note the duration of each write and the checksum of each file that it puts in its place."""
    replaced, seconds, move = list[tuple[str, str]](), list[float](), os.replace

    class Timed(PartFolder):
        def __init__(self, beside: Path) -> None:
            self.began = time.perf_counter()
            super().__init__(beside)

        def remove(self) -> None:
            super().remove()
            seconds.append(time.perf_counter() - self.began)

    def noted(source: Path, target: Path) -> None:
        if folder in Path(target).parents:
            replaced.append((str(Path(target).relative_to(folder)), checksum(Path(source))))
        move(source, target)

    atomic.PartFolder, os.replace = Timed, noted  # type: ignore[misc, assignment]
    status = work.new(folder)
    notes.write_text(json.dumps({"replaced": replaced, "seconds": seconds}))
    return status


def reference(work: Work, old: Path, scratch: Path) -> Reference:
    """Run a work twice without interruption; files whose contents differ hold times."""
    found = []
    for number in range(2):
        folder = Path(shutil.copytree(old, scratch / f"reference-{number}"))
        notes = scratch / f"notes-{number}.json"
        if status_of(in_child(lambda folder=folder, notes=notes: record(work, folder, notes))) != 0:  # type: ignore[misc]
            raise SystemExit(f"{work.name}: failed without a kill")
        found.append(json.loads(notes.read_text()))
    versions = [defaultdict[str, list[str]](list) for _ in found]
    for content, named in zip(found, versions, strict=True):
        for name, value in content["replaced"]:
            named[name].append(value)
    steady = {name: values for name, values in versions[0].items() if versions[1].get(name) == values}
    last = {name: values[-1] for name, values in steady.items() if (scratch / "reference-0" / name).exists()}
    return Reference(found[0]["seconds"], {name: set(values) for name, values in steady.items()}, last)


def kill_one(work: Work, folder: Path, number: int, delay: float) -> bool:
    """Run a work, and kill it a time after the beginning of a write; returns whether it was reached."""
    read, write = os.pipe()

    def announced() -> int:
        """Run the work in the child process, and announce to this one that the chosen write begins."""
        left = [number]

        class Announced(PartFolder):
            def __init__(self, beside: Path) -> None:
                if left[0] == 0:
                    os.write(write, b"x")
                left[0] -= 1
                super().__init__(beside)

        atomic.PartFolder = Announced  # type: ignore[misc]
        return work.new(folder)

    child = in_child(announced)
    os.close(write)
    if os.read(read, 1):
        time.sleep(delay)
        os.kill(child, signal.SIGKILL)
    os.close(read)
    return status_of(child) == -signal.SIGKILL


def check(work: Work, folder: Path, old: dict[str, str], known: Reference, tally: Tally, when: str) -> None:
    """Check all files of a folder."""
    there = list(files_of(folder))
    for name in old.keys() - set(there):
        if not any(Path(name).match(pattern) for pattern in work.may_go):
            tally.faults.append(f"{work.name}: {name} is missing {when}")
    for name in there:
        found = checksum(folder / name)
        kind = "old" if found == old.get(name) else "new" if found in known.versions.get(name, ()) else "times"
        if kind == "times":
            tally.faults += [f"{work.name}: {fault} {when}" for fault in _damage(folder, name, known)]
        tally.files[kind] += 1


def _damage(folder: Path, name: str, known: Reference) -> list[str]:
    """Return what is wrong with a file that is none of the versions that are known."""
    if name in known.versions:
        return [f"{name} is neither old nor new"]
    try:
        read_file(folder / name)
    except Exception as error:
        return [f"{name} is damaged: {error}"]
    return []


def check_next(work: Work, folder: Path, known: Reference, tally: Tally) -> None:
    """Run a work again after a kill, and check that it ends as if nothing had happened."""
    status = status_of(in_child(lambda: work.new(folder)))
    if status != 0:
        tally.faults.append(f"{work.name}: the next run ended with status {status}")
    if work.is_project and status_of(in_child(lambda: work.new(folder))) != 0:
        tally.faults.append(f"{work.name}: the next run left a damaged project")
    if list(folder.rglob(PARTS)):
        tally.faults.append(f"{work.name}: a part is left after the next run")
    for name, value in () if work.is_project else known.last.items():
        if not (folder / name).exists() or checksum(folder / name) != value:
            tally.faults.append(f"{work.name}: {name} is not the new one after the next run")


def kill_often(work: Work, scratch: Path, random: np.random.Generator, most: int) -> Tally:
    """Kill a work many times at a random time within a random write, each time in a copy of the old folder."""
    old, tally = scratch / "old", Tally()
    old.mkdir(parents=True)
    if status_of(in_child(lambda: work.old(old))) != 0:
        raise SystemExit(f"{work.name}: the old files could not be written")
    known = reference(work, old, scratch)
    before = {name: checksum(old / name) for name in files_of(old)}
    while tally.kills < most:
        folder = Path(shutil.copytree(old, scratch / "killed"))
        number = int(random.integers(len(known.seconds)))
        if kill_one(work, folder, number, random.uniform(0.0, 0.8) * known.seconds[number]):
            tally.kills += 1
            tally.parts += bool(list(folder.rglob(PARTS)))
            check(work, folder, before, known, tally, f"after kill {tally.kills}")
            check_next(work, folder, known, tally)
        shutil.rmtree(folder)
    return tally


@dataclass(frozen=True)
class Options:
    """What is killed."""

    kills: int = 200
    seed: int = 0
    only: tuple[str, ...] = ()
    """names of works; default: all"""


def kills(arguments: Options) -> Rows:
    """Kill all works, and print a table."""
    check_display()
    load_modules()
    logging.disable()
    faults, began = list[str](), time.perf_counter()
    yield "run", "kills", "left a part", "whole old files", "whole new files", "whole files with times", "faults"
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "inputs").mkdir()
        tempfile.tempdir = name  # Folders that killed processes leave there are removed with it.
        for number, work in enumerate(works(Path(name) / "inputs")):
            if arguments.only and work.name not in arguments.only:
                continue
            random = np.random.default_rng([arguments.seed, number])
            tally = kill_often(work, Path(name) / work.name, random, round(work.share * arguments.kills))
            files = (tally.files[kind] for kind in ("old", "new", "times"))
            yield work.name, tally.kills, tally.parts, *files, len(tally.faults)
            faults += tally.faults
    yield f"{time.perf_counter() - began:.0f} s"
    yield from faults
    return int(bool(faults))
