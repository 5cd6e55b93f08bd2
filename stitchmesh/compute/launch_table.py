# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches on a CPU as a table that native code works through, on one thread or on several.

A row of the table is a launch: the address of the compiled kernel, that of its arguments, the number of its elements,
and how many of them form a part. Every thread goes through the rows from the first to the last. In each row it takes
one part after the other, until no part is left, and then waits until all parts of the row are done, also those of other
threads. A launch therefore begins only after the launch before it has ended, as on one thread.

The calling thread opens the table and closes it at the end. Other threads may come late, even after the end: an open
table is one in which they may take parts, and in a closed one nothing is left. After it has closed the table the
calling thread waits until no other thread is in it, and sets its counters to zero for the next time.

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
from stitchmesh.compute.thread_team import Work, share

PART = 256
"""Elements of a part, a multiple of all widths of vector instructions. Of a kernel with blocks a part is one block."""
PARTS_PER_THREAD = 8
"""Parts for which it pays to wake one more thread; one block is enough."""
ONE_MEMORY = ("tile", "atomic")
"""How the names of those functions of Warp begin whose kernels form one part."""
LINE = 16
"""Integers of a line of the cache; each counter has a line of its own."""
CLOSED = 1
"""The counter that is not zero while the table is closed."""

_WORK_THROUGH = """
    struct Bounds { unsigned int shape[2]; size_t size, coord_mult; };
    int* inside = counters.data;
    int* closed = inside + 16;
    const auto wait = [give_way](const int* counter, int value) {
        for (int looks = 0; __atomic_load_n(counter, __ATOMIC_SEQ_CST) != value; ++looks)
            if (looks > 20000) ((void (*)())give_way)();
    };
    __atomic_fetch_add(inside, 1, __ATOMIC_SEQ_CST);
    if (!__atomic_load_n(closed, __ATOMIC_SEQ_CST)) {
        const long long* row = table.data;
        int* taken = closed + 16;
        for (int launch = 0; launch < table.shape[0]; ++launch, row += 5, taken += 32) {
            const auto run = (void (*)(Bounds*, void*))row[0];
            const long long count = row[2], lanes = row[3], size = row[4];
            const int parts = (int)((count + size - 1) / size);
            int* done = taken + 16;
            for (int part; (part = __atomic_fetch_add(taken, 1, __ATOMIC_RELAXED)) < parts;) {
                const long long first = part * size, last = first + size < count ? first + size : count;
                Bounds bounds = {{(unsigned int)last, (unsigned int)lanes}, (size_t)((last - first) * lanes), 1};
                run(&bounds, (void*)row[1]);
                __atomic_fetch_add(done, 1, __ATOMIC_RELEASE);
            }
            wait(done, parts);
        }
    }
    if (closes) {
        __atomic_store_n(closed, 1, __ATOMIC_SEQ_CST);
        wait(inside, 1);
        for (int k = 0; k < 2 * table.shape[0]; ++k) closed[16 + 16 * k] = 0;
    }
    __atomic_fetch_sub(inside, 1, __ATOMIC_SEQ_CST);
"""


@wp.func_native(_WORK_THROUGH)
def take_parts(
    table: wp.array2d(dtype=wp.int64), give_way: wp.uint64, closes: bool, counters: wp.array2d(dtype=wp.int32)
):
    """Take parts of launches until none is left; ``give_way`` is the address of a function of the system."""
    ...


@kernel
def work_through(
    # model
    table: wp.array2d(dtype=wp.int64),
    give_way: wp.uint64,
    closes: bool,
    # state in and out
    counters: wp.array2d(dtype=wp.int32),
) -> None:
    """Take parts of launches until none is left; the thread that opened the table closes it."""
    take_parts(table, give_way, closes, counters)


class LaunchTable:
    """Prepared launches on a CPU, which run one after the other."""

    def __init__(self, launches: Sequence[wp.Launch]) -> None:
        """Make the table; the arrays and numbers that the launches name stay the same."""
        self._launches = list(launches)
        self._arguments = [_arguments(launch) for launch in launches]
        rows = [
            [_address(launch.hooks.forward), ctypes.addressof(arguments), *_extents(launch), _part_size(launch)]
            for launch, arguments in zip(launches, self._arguments, strict=True)
        ]
        self._table = wp.array(rows, dtype=wp.int64, device="cpu")
        self._counters = np.zeros((2 + 2 * len(rows), LINE), dtype=np.int32)
        self._counters[CLOSED] = 1
        self._threads = max(useful_threads(launch) for launch in launches)
        self._own, self._other = self._work(closes=True), self._work(closes=False)

    def launch(self) -> None:
        """Run all launches."""
        self._counters[CLOSED] = 0
        try:
            if self._threads > 1:
                share(self._own, self._other, self._threads)
            else:
                self._own()
        finally:
            if not self._counters[CLOSED, 0]:  # an interrupt before the work of this thread
                self._own()

    def _work(self, *, closes: bool) -> Work:
        """The work of the calling thread, which closes the table, or that of another one."""
        counters = wp.array(self._counters, dtype=wp.int32, device="cpu", copy=False)
        inputs = [self._table, wp.uint64(_give_way()), closes, counters]
        launch = wp.launch(work_through, 1, inputs, device="cpu", record_cmd=True)
        arguments = _arguments(launch)
        return functools.partial(_call, launch, ctypes.byref(launch.bounds), ctypes.byref(arguments))


def _call(launch: wp.Launch, bounds: Any, arguments: Any) -> None:
    """Run a kernel without what ``wp.Launch.launch`` does again each time."""
    launch.hooks.forward(bounds, arguments)


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


def useful_threads(launch: wp.Launch) -> int:
    """Number of threads that a launch is enough for."""
    parts = -(-_extents(launch)[0] // _part_size(launch))
    return parts // PARTS_PER_THREAD if len(launch.bounds.shape) == 1 else parts


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
