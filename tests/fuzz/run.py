# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading of damaged files in worker processes, which may crash, hang or run out of memory without an end of the run.

A worker is a fork of this process. Before each file it writes the number of the input on a board in shared memory. If
the worker dies, this process notes the input as a finding and starts another worker behind it.
"""

from __future__ import annotations

import faulthandler
import json
import math
import mmap
import os
import re
import resource
import signal
import struct
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from tests.fuzz.mutations import mutated
from tests.fuzz.readers import READERS, Reader

MEMORY = 128 * 2**20, 500
"""Address space that a reader may add while it reads: a constant [bytes], and bytes for each byte of the file."""
MEMORY_FOLDER = Path("/dev/shm")
"""Folder in memory, if the system has one, where files are written and read faster."""
CPU_SECONDS = 10.0
"""Processor time of one file beyond which its reader counts as hanging [s]; undamaged files take milliseconds."""
IDLE_SECONDS = 120.0
"""Time without progress beyond which a reader counts as waiting for ever [s]."""
LONGEST_MESSAGE = 2000
"""Number of characters of an error beyond which it is no single line that a user reads."""
TRIES, TRIES_WITHOUT_END = 150, 5
"""Numbers of smaller files that are tried for a finding, and for one that takes ``CPU_SECONDS`` each time."""


@dataclass
class Findings:
    """What a run over damaged files found for one reader."""

    reader: str
    outcomes: Counter[str] = field(default_factory=Counter)
    """Number of inputs of each outcome: ``value``, or the name of the error."""
    faults: dict[str, list[int]] = field(default_factory=dict)
    """Numbers of the inputs of each fault, an outcome that must not be."""

    @property
    def inputs(self) -> int:
        """Number of inputs."""
        return sum(self.outcomes.values())


def seeds_of(reader: Reader) -> list[bytes]:
    """Return the undamaged files of a reader; the first one is read, so that workers find all modules loaded."""
    with tempfile.TemporaryDirectory() as folder:
        seeds = list(reader.seeds(Path(folder)))
        path = Path(folder) / f"undamaged{reader.suffix}"
        path.write_bytes(seeds[0])
        reader.read(path)
    return seeds


def damaged(reader: Reader, seeds: Sequence[bytes], seed: int, number: int) -> bytes:
    """Return the damaged file of a number; the same seed and number give the same file."""
    random = Random(seed << 32 | number)
    return mutated(random, random.choice(seeds), reader.kinds)


def outcome(reader: Reader, path: Path) -> str:
    """Read a file, and return ``value``, the name of an error that the reader may raise, or ``fault ...``."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            reader.read(path)
    except reader.errors as error:
        text = str(error)
        if not reader.has_own_process and any(isinstance(cause, MemoryError) for cause in _causes(error)):
            return f"fault MemoryError behind a {type(error).__name__} {_place(error)}"
        if len(text.splitlines()) != 1 or len(text) > LONGEST_MESSAGE:
            return f"fault {type(error).__name__} of {len(text.splitlines())} lines {_place(error)}"
        return type(error).__name__
    except BaseException as error:
        if reader.has_own_process and isinstance(error, MemoryError):
            return "FileError"  # The process of the reader has a limit of its own.
        return f"fault {type(error).__name__} {_place(error)}"
    return "value"


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _place(error: BaseException) -> str:
    """Return the last place of the library in the traceback of an error."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "/stitchmesh/" in frame.filename]
    return f"at {Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else ""


@contextmanager
def limited_memory(size: int) -> Iterator[None]:
    """Limit the address space of this process to what it has now, and what a file of a size may need [bytes]."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    before = resource.getrlimit(resource.RLIMIT_AS)
    most = pages * resource.getpagesize() + MEMORY[0] + MEMORY[1] * size
    resource.setrlimit(resource.RLIMIT_AS, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def fuzz(
    name: str, count: int, *, seconds: float = math.inf, seed: int = 0, processes: int = 1,
    report: Callable[[Findings], None] = lambda found: None,
) -> Findings:  # fmt: skip
    """Read damaged files with a reader.

    Args:
        name: name of the reader.
        count: number of files.
        seconds: time after which the workers are ended, if they have not read all files.
        seed: seed of the random numbers.
        processes: number of workers.
        report: function that is called about once a second with the findings so far.
    """
    with tempfile.TemporaryDirectory(dir=MEMORY_FOLDER if MEMORY_FOLDER.is_dir() else None) as folder:
        seeds = seeds_of(READERS[name])
        lanes = [_Lane(name, seeds, seed, range(lane, count, processes), Path(folder)) for lane in range(processes)]
        pause, end = 0.01, time.monotonic() + seconds
        while sum(lane.watch() for lane in lanes) and time.monotonic() < end:
            report(_together(name, lanes))
            pause = min(1.0, 1.3 * pause)
            time.sleep(pause)
        for lane in lanes:
            lane.end()
        return _together(name, lanes)


def _together(name: str, lanes: Sequence[_Lane]) -> Findings:
    total = Findings(name)
    for lane in lanes:
        lane.collect()
        total.outcomes.update(lane.found.outcomes)
        for fault, numbers in lane.found.faults.items():
            total.faults.setdefault(fault, []).extend(numbers)
    return total


class _Lane:
    """A part of the inputs, read by one worker after the other."""

    def __init__(self, name: str, seeds: Sequence[bytes], seed: int, numbers: range, folder: Path) -> None:
        self.reader, self.seeds, self.seed, self.numbers = READERS[name], seeds, seed, numbers
        self.folder = Path(tempfile.mkdtemp(dir=folder))
        self.lines = self.folder.with_suffix(".jsonl")
        self.lines.touch()
        self.read_up_to = 0
        self.found = Findings(name)
        self.board = mmap.mmap(-1, 8)
        self.done = False
        self._start(0)

    def _start(self, first: int) -> None:
        self.board[:] = struct.pack("<q", first)
        self.process = in_fork(lambda: self._work(first))
        self.seen, self.cpu, self.since = first, 0.0, time.monotonic()

    def _work(self, first: int) -> None:
        """Read the inputs from a place in the list on; runs in a worker."""
        path = self.folder / f"input{self.reader.suffix}"
        with self.lines.open("a") as lines:
            for place in range(first, len(self.numbers)):
                self.board[:] = struct.pack("<q", place)
                content = damaged(self.reader, self.seeds, self.seed, self.numbers[place])
                path.write_bytes(content)
                with limited_memory(len(content)):
                    found = outcome(self.reader, path)
                lines.write(json.dumps([self.numbers[place], found]) + "\n")
                lines.flush()
        self.board[:] = struct.pack("<q", len(self.numbers))

    def watch(self) -> bool:
        """Look after the worker; return whether there is more to do."""
        if self.done:
            return False
        ended, status = os.waitpid(self.process, os.WNOHANG)
        place = struct.unpack("<q", self.board[:])[0]
        if ended:
            self.done = place >= len(self.numbers)
            if not self.done:
                self._note(place, _ended(self.reader, _end(status)))
        elif place != self.seen:
            self.seen, self.cpu, self.since = place, cpu_seconds(self.process), time.monotonic()
        elif hangs(self.process, self.cpu, self.since):
            os.kill(self.process, signal.SIGKILL)
            os.waitpid(self.process, 0)
            self._note(place, _ended(self.reader, "no end"))
        return not self.done

    def end(self) -> None:
        """End the worker, if it has not ended."""
        if not self.done:
            os.kill(self.process, signal.SIGKILL)
            os.waitpid(self.process, 0)

    def _note(self, place: int, fault: str) -> None:
        """Note a fault that ended the worker, and go on behind its input."""
        with self.lines.open("a") as lines:
            lines.write(json.dumps([self.numbers[place], fault]) + "\n")
        self.done = place + 1 >= len(self.numbers)
        if not self.done:
            self._start(place + 1)

    def collect(self) -> None:
        """Read the new lines of the workers."""
        with self.lines.open() as lines:
            lines.seek(self.read_up_to)
            text = lines.read()
        whole = text[: text.rfind("\n") + 1]
        self.read_up_to += len(whole.encode())
        for line in whole.splitlines():
            number, found = json.loads(line)
            self.found.outcomes[found.split()[0]] += 1
            if found.startswith("fault "):
                self.found.faults.setdefault(found[6:], []).append(number)


def in_fork(work: Callable[[], None]) -> int:
    """Call a function in a fork of this process, without a word on its error output, and return the process."""
    sys.stdout.flush()
    process = os.fork()
    if process:
        return process
    status = 1
    try:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        faulthandler.disable()
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(nowhere, stream)
        work()
        status = 0
    finally:
        os._exit(status)


def cpu_seconds(process: int) -> float:
    """Return the processor time of a process [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def hangs(process: int, cpu: float, since: float) -> bool:
    """Return whether a process has used too much time since it had a processor time and since a moment [s]."""
    return cpu_seconds(process) - cpu > CPU_SECONDS or time.monotonic() - since > IDLE_SECONDS


def _ended(reader: Reader, end: str) -> str:
    """Return the outcome of an input whose reader ended its process, or had to be ended."""
    return "FileError" if reader.has_own_process else f"fault process: {end}"


def _end(status: int) -> str:
    return signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else f"status {os.WEXITSTATUS(status)}"


def outcome_of(reader: Reader, content: bytes) -> str:
    """Return the outcome of one content, read in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        path, answer = Path(folder) / f"input{reader.suffix}", Path(folder) / "answer"
        path.write_bytes(content)

        def work() -> None:
            with limited_memory(len(content)):
                found = outcome(reader, path)
            answer.write_text(found)

        process, since = in_fork(work), time.monotonic()
        while True:
            ended, status = os.waitpid(process, os.WNOHANG)
            if ended:
                return answer.read_text() if answer.exists() else _ended(reader, _end(status))
            if hangs(process, 0.0, since):
                os.kill(process, signal.SIGKILL)
                os.waitpid(process, 0)
                return _ended(reader, "no end")
            time.sleep(0.002)


def minimized(reader: Reader, content: bytes) -> bytes:
    """Return a smaller content with the same outcome: parts are left out, each half as long as the ones before."""
    wanted, tries, size = outcome_of(reader, content), 0, max(1, len(content) // 2)
    most = TRIES_WITHOUT_END if wanted.endswith("no end") else TRIES
    while size >= 1 and tries < most:
        start = 0
        while start < len(content) and tries < most:
            smaller = content[:start] + content[start + size :]
            tries += 1
            if outcome_of(reader, smaller) == wanted:
                content = smaller
            else:
                start += size
        size //= 2
    return content


def keep_findings(folder: Path, found: Findings, seed: int) -> list[str]:
    """Write a minimized file for each fault, and return a line about each fault."""
    lines = []
    reader = READERS[found.reader]
    seeds = seeds_of(reader)
    for fault, numbers in sorted(found.faults.items()):
        content = minimized(reader, damaged(reader, seeds, seed, min(numbers)))
        name = re.sub(r"\W+", "-", f"{found.reader} {fault}")[:80] + reader.suffix
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
        lines.append(f"{found.reader}: {fault}: {len(numbers)} inputs, first {min(numbers)}, seed {seed}: {name}")
    return lines
