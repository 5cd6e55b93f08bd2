# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Compiles kernels for a device before they are launched, in several processes.

Warp compiles a kernel when it is launched for the first time, one kernel after another, and keeps the result in a
folder. The name of the result is a hash of the text of the kernel, of its functions and of the options of the compiler,
so a later process finds exactly what it would have compiled. The kernels are those of all modules of the package that
declare kernels, in all variants (``kernel_variants``); a new kernel is compiled too, without an entry in a list.

Threads of one process would compile one kernel at a time. The work is therefore shared by processes: each one makes the
same list of kernels, and compiles those whose numbers it gets on its standard input.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from importlib import import_module
from itertools import product
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Literal

from stitchmesh.child_interpreter import PACKAGES, clean_environment, python_command
from stitchmesh.compute.compiled import compile_kernel, compiled_folder, is_compiled
from stitchmesh.compute.device import device_named
from stitchmesh.compute.free_memory import host_memory
from stitchmesh.compute.kernel_variants import KernelForm, kernels_of_module
from stitchmesh.compute.launch import BLOCK
from stitchmesh.compute.precision import scalar_named
from stitchmesh.compute.threads import core_count
from stitchmesh.errors import CompilationError, ParameterError
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.quality import PRESETS

STAGE = "warm-up"
"""Name of the stage for ``progress``."""
DECLARES_KERNELS = "stitchmesh.compute.kernel import"
"""Words in the text of each module that declares kernels."""
PRECISIONS = ("float32", "float64")
WORKER_MEMORY = 5e8
"""Memory that a process takes [bytes]."""
FEWEST_WORKERS, MOST_WORKERS = 4, 64
"""Bounds of the number of processes: the least that compile kernels before a relaxation, and the most of a warm-up."""
OF_EVERY_RELAXATION = "stitchmesh.yarnrelax.energies.evaluation"
"""Module of kernels that every relaxation of yarns launches: if they are compiled, the machine has relaxed yarns."""


@dataclass(frozen=True)
class WarmUp:
    """What ``warm_up`` did."""

    device: str
    """Warp's name of the device."""
    compiled: int
    """Number of kernels that were compiled."""
    kept: int
    """Number of kernels that had been compiled before."""
    seconds: float
    """Time of all [s]."""
    workers: int
    """Number of processes; 0 if there was nothing to compile."""
    folder: Path
    """Folder of the compiled kernels."""


@dataclass(frozen=True)
class KernelChoice:
    """Kernels of some modules in some forms, on a device."""

    device: str
    """Warp's name of the device."""
    modules: tuple[str, ...]
    """Names of the modules."""
    forms: tuple[tuple[str, bool], ...]
    """Precisions, each with whether yarns lie on a lattice."""

    def kernels(self) -> list[tuple[Any, int]]:
        """Return the kernels, each with the threads of its blocks, in an order that is the same in all processes."""
        on_gpu = device_named(self.device).is_cuda
        found: dict[tuple[Any, int], None] = {}
        modules = [import_module(name) for name in self.modules]
        for (precision, on_lattice), module in product(self.forms, modules):
            relaxing = quadratures_of(precision)
            measured = () if precision == "float32" else quadratures_of("float32")  # measurements are exact
            form = KernelForm(scalar_named(precision), on_lattice, on_gpu, relaxing, measured)
            for kernel in kernels_of_module(module, form):
                if not on_gpu or kernel.tile is not None:
                    found[kernel, (kernel.tile or BLOCK) if on_gpu else 1] = None
        return list(found)


def every_kernel(device: str) -> KernelChoice:
    """Return the choice of all kernels of the package for a device."""
    return KernelChoice(device, tuple(kernel_modules()), tuple(product(PRECISIONS, (False, True))))


def quadratures_of(precision: str) -> tuple[int, ...]:
    """Return the numbers of Gauss points of the presets of a precision, also where segments are refined."""
    presets = [preset for preset in PRESETS.values() if preset.precision == precision]
    found = {count for each in presets for count in (each.quadrature_points, each.refined(each.quadrature_points))}
    return tuple(sorted(found))


def kernel_modules() -> Iterator[str]:
    """Yield the names of all modules of the package that declare kernels."""
    package = Path(PACKAGES) / "stitchmesh"
    for path in sorted(package.rglob("*.py")):
        if DECLARES_KERNELS in path.read_text(encoding="utf-8"):
            yield ".".join(path.relative_to(PACKAGES).with_suffix("").parts)


def warm_up(
    device: str | None = None, *, workers: int | None = None, progress: Progress | Literal[False] | None = None
) -> WarmUp:
    """Compile all kernels for a device that have not been compiled, so that later runs start at once.

    If it is interrupted, the kernels that have been compiled are kept.

    Args:
        device: Warp's name of the device; the first GPU or else the CPU if None.
        workers: number of processes; if None, one for each core, as far as the memory suffices.
        progress: as for ``stitchmesh.progress``.

    Raises:
        ParameterError: there is no such device, or the number of processes is less than 1.
        CompilationError: a kernel cannot be compiled, or its process ended.
    """
    if workers is not None and workers < 1:
        raise ParameterError(f"workers: got {workers}; expected at least 1")
    began = time.monotonic()
    choice = every_kernel(str(device_named(device)))
    missing = _missing(choice)
    workers = min(workers or usual_workers(), len(missing))
    with shown_stages(progress) as report:
        compile_kernels(choice, missing, workers, report)
    return WarmUp(
        device=choice.device, compiled=len(missing), kept=len(choice.kernels()) - len(missing),
        seconds=time.monotonic() - began, workers=workers, folder=compiled_folder(),
    )  # fmt: skip


def compile_before_relaxing(device: str | None, *, on_lattice: bool, progress: Progress) -> None:
    """Compile what a relaxation may need, if this machine has not yet relaxed yarns and has several cores for it.

    These are the kernels of all modules that have been imported, more than the relaxation launches. On few cores it is
    therefore faster to compile one kernel after another when it is launched.

    Args:
        device: Warp's name of the device; the first GPU or else the CPU if None.
        on_lattice: whether a swatch is relaxed.
        progress: called with the part that is compiled.

    Raises:
        ParameterError: there is no such device.
        CompilationError: as for ``warm_up``.
    """
    if usual_workers() < FEWEST_WORKERS:
        return
    found = device_named(device)
    forms = tuple((precision, on_lattice) for precision in (PRECISIONS if on_lattice else PRECISIONS[:1]))
    if not _missing(KernelChoice(str(found), (OF_EVERY_RELAXATION,), forms[:1])):
        return
    compile_imported(str(found), forms, progress)


def compile_imported(device: str, forms: tuple[tuple[str, bool], ...], progress: Progress) -> None:
    """Compile all kernels of the modules that have been imported, as far as they have not been compiled.

    Args:
        device: Warp's name of the device.
        forms: precisions, each with whether yarns lie on a lattice.
        progress: called with the part that is compiled.

    Raises:
        CompilationError: as for ``warm_up``.
    """
    choice = KernelChoice(device, tuple(name for name in kernel_modules() if name in sys.modules), forms)
    missing = _missing(choice)
    compile_kernels(choice, missing, min(usual_workers(), len(missing)), progress)


def usual_workers() -> int:
    """Return the number of processes that the cores and the memory allow."""
    return max(1, min(core_count(), int(host_memory() / WORKER_MEMORY), MOST_WORKERS))


def _missing(choice: KernelChoice) -> list[int]:
    """Return the numbers of the kernels of a choice that have not been compiled."""
    device = device_named(choice.device)
    return [number for number, (kernel, block) in enumerate(choice.kernels()) if not is_compiled(kernel, block, device)]


def compile_kernels(choice: KernelChoice, numbers: Sequence[int], workers: int, progress: Progress) -> None:
    """Compile the kernels of a choice that have these numbers.

    Raises:
        CompilationError: a kernel cannot be compiled, or its process ended.
    """
    waiting: SimpleQueue[int] = SimpleQueue()
    for number in numbers:
        waiting.put(number)
    done: SimpleQueue[str | None] = SimpleQueue()
    with ExitStack() as stack:
        team = [stack.enter_context(_Worker(choice)) for _ in range(workers)]
        pool = stack.enter_context(ThreadPoolExecutor(max(workers, 1)))
        for worker in team:
            stack.callback(worker.end)  # so that the pool need not wait for answers
        served = [pool.submit(worker.serve, waiting, done) for worker in team]
        for count in range(len(numbers)):
            name = done.get()
            if name is None:
                break
            progress(STAGE, (count + 1) / len(numbers), f"{count + 1:,} of {len(numbers):,} kernels, {name}")
        for future in as_completed(served):
            future.result()


class _Worker:
    """A process that compiles kernels."""

    def __init__(self, choice: KernelChoice) -> None:
        """Start the process."""
        asked = json.dumps([choice.device, choice.modules, choice.forms])
        # In a session of its own, so that an interrupt at the terminal reaches only the program, which ends the process
        self._process = subprocess.Popen(
            python_command("-m", "stitchmesh.first_use", asked), env=clean_environment(), stdin=subprocess.PIPE,
            stdout=subprocess.PIPE, text=True, start_new_session=True,
        )  # fmt: skip

    def __enter__(self) -> _Worker:
        return self

    def __exit__(self, *_error: object) -> None:
        self.end()
        self._process.communicate()

    def end(self) -> None:
        """End the process; a kernel that it compiles is compiled again the next time."""
        self._process.kill()

    def serve(self, waiting: SimpleQueue[int], done: SimpleQueue[str | None]) -> None:
        """Let the process compile one waiting kernel after another; ``done`` gets their names, and None at a failure.

        Raises:
            CompilationError: a kernel cannot be compiled, or the process ended.
        """
        try:
            with suppress(Empty):
                while True:
                    done.put(self._compile(waiting.get_nowait()))
        except BaseException:
            done.put(None)
            raise

    def _compile(self, number: int) -> str:
        """Let the process compile a kernel, and return the name of the kernel."""
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            self._process.stdin.write(f"{number}\n")
            self._process.stdin.flush()
            answer = json.loads(self._process.stdout.readline() or "null")
        except (BrokenPipeError, ValueError):
            answer = None
        if answer is None:
            found = f"a process that compiles kernels ended with status {self._process.wait()}"
            raise CompilationError(f"{found}; memory may be short, so take fewer workers")
        if "error" in answer:
            raise CompilationError(answer["error"])
        return str(answer["kernel"])


def work() -> None:
    """Compile the kernels whose numbers stand on standard input: the main part of a process."""
    device, modules, forms = json.loads(sys.argv[1])
    choice = KernelChoice(device, tuple(modules), tuple((precision, lattice) for precision, lattice in forms))
    found, kernels = device_named(device), choice.kernels()
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # messages of compilers are no answers
    for line in sys.stdin:
        kernel, block = kernels[int(line)]
        try:
            compile_kernel(kernel, block, found)
            answer = {"kernel": kernel.func.__name__}
        except CompilationError as error:
            answer = {"error": str(error)}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    work()
