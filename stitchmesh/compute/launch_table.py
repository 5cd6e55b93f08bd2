# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches on a CPU as a table that native code works through, on one thread or on several.

A row of the table is a launch: the address of the compiled kernel, that of its arguments, the number of its elements,
and how many of them form a part. Every thread goes through the rows from the first to the last. In each row it takes
one part after the other, until no part is left, and then waits until all parts of the row are done, also those of other
threads. A launch therefore begins only after the launch before it has ended, as on one thread.

An element computes the same in whichever thread it runs. The parts depend on the number of elements only, not on the
number of threads, so that vectorised loops treat each element in the same way too. Results therefore have the same bits
for any number of threads. No element may read what another one writes, which a GPU demands as well.

Two kinds of kernels form one part: those with tiles, because Warp keeps the tiles of all threads in one memory, and
those with atomic additions, because Warp's additions on a CPU are not atomic.
"""

# no postponed annotations: Warp evaluates the types of native functions directly
# mypy: disable-error-code="valid-type,no-untyped-def"

import ctypes
import functools
import inspect
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import RUNS_IN_PARTS, kernel
from stitchmesh.compute.thread_team import share

PART = 256
"""Elements of a part, a multiple of all widths of vector instructions. Of a kernel with blocks a part is one block."""
FEWEST_PARTS, FEWEST_BLOCKS = 16, 2
"""Parts of the largest launch, or blocks, from which several threads are faster than one."""
ONE_MEMORY = ("tile", "atomic")
"""How the names of those functions of Warp begin whose kernels form one part."""

_WORK_THROUGH = """
    struct Bounds { unsigned int shape[2]; size_t size, coord_mult; };
    const long long* row = table.data;
    int* taken = counters.data;
    for (int launch = 0; launch < table.shape[0]; ++launch, row += 5, taken += 32) {
        const auto run = (void (*)(Bounds*, void*))row[0];
        const long long count = row[2], lanes = row[3], size = row[4];
        const int parts = (int)((count + size - 1) / size);
        int* done = taken + 16;  // on another line of the cache
        for (int part; (part = __atomic_fetch_add(taken, 1, __ATOMIC_RELAXED)) < parts;) {
            const long long first = part * size, last = first + size < count ? first + size : count;
            Bounds bounds = {{(unsigned int)last, (unsigned int)lanes}, (size_t)((last - first) * lanes), 1};
            run(&bounds, (void*)row[1]);
            __atomic_fetch_add(done, 1, __ATOMIC_RELEASE);
        }
        for (int looks = 0; __atomic_load_n(done, __ATOMIC_ACQUIRE) < parts; ++looks)
            if (looks > 200) ((void (*)())give_way)();  // rows are short: to sleep would take longer
    }
"""


@wp.func_native(_WORK_THROUGH)
def take_parts(table: wp.array2d(dtype=wp.int64), counters: wp.array2d(dtype=wp.int32), give_way: wp.uint64):
    """Take parts of launches until none is left; ``give_way`` is the address of a function of the system."""
    ...


@kernel
def work_through(
    # model
    table: wp.array2d(dtype=wp.int64),
    give_way: wp.uint64,
    # state in and out
    counters: wp.array2d(dtype=wp.int32),
) -> None:
    """Take parts of launches until none is left."""
    take_parts(table, counters, give_way)


class LaunchTable:
    """Prepared launches on a CPU, which run one after the other."""

    def __init__(self, launches: Sequence[wp.Launch]) -> None:
        """Make the table; the arrays and numbers that the launches name stay the same."""
        self._launches = list(launches)
        self._arguments = [_arguments(launch) for launch in launches]
        sizes = [_part_size(launch) for launch in launches]
        rows = [
            [_address(launch.hooks.forward), ctypes.addressof(arguments), *_extents(launch), size]
            for launch, arguments, size in zip(launches, self._arguments, sizes, strict=True)
        ]
        self._counters = np.zeros((len(rows), 32), dtype=np.int32)
        counters = wp.array(self._counters, dtype=wp.int32, device="cpu", copy=False)
        inputs = [wp.array(rows, dtype=wp.int64, device="cpu"), wp.uint64(_give_way()), counters]
        self._work = wp.launch(work_through, 1, inputs, device="cpu", record_cmd=True)
        self._do: Callable[[], None] = self._work.launch
        if any(is_large(launch) for launch in launches):
            self._do = functools.partial(share, self._work.launch)

    def launch(self) -> None:
        """Run all launches."""
        self._counters[:] = 0
        self._do()


def _arguments(launch: wp.Launch) -> ctypes.Structure:
    """The arguments of a launch as a kernel receives them."""
    values = launch.params[1:]
    return _arguments_type(tuple(type(value) for value in values))(*values)


@functools.cache
def _arguments_type(types: tuple[Any, ...]) -> Any:
    fields = [(f"argument_{number}", kind) for number, kind in enumerate(types)]
    return type("Arguments", (ctypes.Structure,), {"_fields_": fields})


def _extents(launch: wp.Launch) -> tuple[int, int]:
    """Number of elements or of blocks of a launch, and lanes of a block, which is 1 for elements."""
    count = int(launch.bounds.shape[0])
    return count, launch.bounds.size // count


def _part_size(launch: wp.Launch) -> int:
    """How many elements or blocks of a launch form a part."""
    count, _lanes = _extents(launch)
    if not RUNS_IN_PARTS or _uses_one_memory(launch.kernel.func):
        return count
    return PART if len(launch.bounds.shape) == 1 else 1


def is_large(launch: wp.Launch) -> bool:
    """Whether several threads run a launch faster than one."""
    parts = -(-_extents(launch)[0] // _part_size(launch))
    return parts >= (FEWEST_PARTS if len(launch.bounds.shape) == 1 else FEWEST_BLOCKS)


@functools.cache
def _uses_one_memory(function: Callable[..., Any]) -> bool:
    """Whether a function of a kernel, or one that it calls, uses tiles or atomic additions."""
    names = function.__code__.co_names
    if any(name.startswith(ONE_MEMORY) for name in names):
        return True
    known = {**function.__globals__, **inspect.getclosurevars(function).nonlocals}
    called = [known.get(name) for name in (*names, *function.__code__.co_freevars)]
    return any(_uses_one_memory(each.func) for each in called if isinstance(each, wp.Function))


@functools.cache
def _give_way() -> int:
    """Address of the function of the system that lets another thread run."""
    if sys.platform == "win32":
        return _address(ctypes.windll.kernel32.SwitchToThread)
    return _address(ctypes.CDLL(None).sched_yield)


def _address(function: Any) -> int:
    """Address of a native function."""
    return int(ctypes.cast(function, ctypes.c_void_p).value or 0)
