# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading of files by libraries that may end their process, ask for any memory, or not come to an end.

The library therefore reads in a child process, within limits of memory and time that grow with the file. The child
hands over the result in a file with a checksum (``stitchmesh.io.checkpoint_file``). If the child ends early, this is an
ordinary error. The child is a module of this package, whose main part calls ``answer_parent``:

    python -m MODULE NAME FILE ANSWER

``docs/robustness.md`` says which libraries read in a child, and why the others do not.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib import import_module
from os import fspath
from pathlib import Path

from stitchmesh.child_interpreter import clean_environment, python_command
from stitchmesh.errors import FileError
from stitchmesh.io.checkpoint_file import CheckpointFile, read_checkpoint, write_checkpoint
from stitchmesh.io.contents import FilePath, read_bytes

try:
    import resource
except ImportError:  # Windows has no such limits.
    resource = None  # type: ignore[assignment]

STATM = Path("/proc/self/statm")
"""Where Linux shows the pages of memory of this process."""
MEMORY = 2**29, 300
"""Memory that the child may add to what its libraries take: a constant [bytes], and bytes for each byte of the file."""
SECONDS = 6.0, 2e-6
"""Processor time that the child may take: a constant [s], and seconds for each byte of the file."""
WAITING = 20.0
"""The child counts as waiting for ever beyond this multiple of its processor time; the machine may be busy
otherwise."""
ONE_THREAD = {
    "PXR_WORK_THREAD_LIMIT": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MALLOC_ARENA_MAX": "1",
    "ARROW_DEFAULT_MEMORY_POOL": "system",
}  # fmt: skip
"""Each thread of a library reserves memory; without these settings the limit would depend on the number of
processors."""


def answer_of_child(module: str, path: FilePath, *, in_place: bool = False) -> CheckpointFile:
    """Let a module read a file in a process of its own, and return what it hands over (``answer_parent``).

    Args:
        module: the module.
        path: the file.
        in_place: whether the child opens the file itself, because other files of its folder belong to it. Otherwise the
            child gets a copy of the content, which nobody can change meanwhile.

    Raises:
        FileError: the file cannot be read or is malformed, or the process ends.
    """
    name, content = fspath(path), read_bytes(path)
    with tempfile.TemporaryDirectory(prefix="stitchmesh-") as folder:
        answer, file = Path(folder) / "answer.smc", Path(folder) / "content"
        if not in_place:
            file.write_bytes(content)
        nowhere = subprocess.DEVNULL
        try:
            ended = subprocess.run(
                python_command("-m", module, name, name if in_place else str(file), str(answer)),
                env={**clean_environment(), **ONE_THREAD}, stdin=nowhere, stdout=nowhere, stderr=nowhere,
                check=False, timeout=WAITING * _seconds(len(content)),
            )  # fmt: skip
        except subprocess.TimeoutExpired as error:
            found = "its library waits"
            raise FileError(f"{name}: cannot be read ({found}); check the files that it names") from error
        if ended.returncode or not answer.exists():
            found = f"its library could not read it and ended with status {ended.returncode}"
            raise FileError(f"{name}: is damaged, or takes too much memory or time ({found}); write it again")
        read = read_checkpoint(answer)
    if read.header["error"]:
        raise FileError(read.header["error"])
    return read


def answer_parent(read: Callable[[str, Path], CheckpointFile], *libraries: str) -> None:
    """Do the work of a child: read the file that the arguments of this process name; write its content or the error.

    Args:
        read: reads the file; its arguments are the name for messages, and the file.
        libraries: modules to load first; their memory and time do not count.
    """
    name, file, answer = sys.argv[1:]
    for library in libraries:
        import_module(library)
    _limit(Path(file).stat().st_size)
    try:
        content = read(name, Path(file))
        content = CheckpointFile({"error": "", **content.header}, content.arrays)
    except FileError as refused:
        content = CheckpointFile({"error": str(refused)}, {})
    except MemoryError:
        content = CheckpointFile({"error": f"{name}: needs very much more memory than its size; write it again"}, {})
    write_checkpoint(answer, content)


def _seconds(size: int) -> float:
    return SECONDS[0] + SECONDS[1] * size


def _limit(size: int) -> None:
    """Limit memory, processor time and the answer of this process, for a file of a size [bytes]."""
    if resource is None:
        return
    pages = int(STATM.read_text().split()[0]) if STATM.exists() else 0
    memory = MEMORY[0] + MEMORY[1] * size
    limits = {
        resource.RLIMIT_AS: pages * resource.getpagesize() + memory, resource.RLIMIT_FSIZE: memory,
        resource.RLIMIT_CPU: int(_seconds(size)), resource.RLIMIT_CORE: 0,
    }  # fmt: skip
    for kind, value in limits.items():
        hard = resource.getrlimit(kind)[1]
        resource.setrlimit(kind, (value if hard == resource.RLIM_INFINITY else min(value, hard), hard))
