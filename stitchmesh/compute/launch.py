# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches of kernels; on a CPU all cores share a launch.

A GPU runs a launch by itself. On a CPU, native code works through a table of launches, on one thread or on several.

A row of the table is a launch: the address of the compiled kernel, the address of its arguments, the number of its
elements, and the number of elements in a part. Every thread goes through the rows from the first to the last. In each
row it waits until all parts are done, also the parts of other threads. A launch therefore begins only after the launch
before it has ended, as on one thread.

Each thread has its own range of the parts of a row. This is the same range of the elements in every row, so that the
cache of its core holds most of what it reads. It takes one part after the other until its range is empty. Then it takes
parts from the ranges of other threads, which may be late or interrupted.

The calling thread opens the table, and closes it at the end. Other threads may come late, even after the end, but they
take parts only while the table is open. The calling thread closes the table, waits until no other thread is in it, and
sets its counters to zero for the next time.

The result of an element does not depend on the thread that computes it. The parts depend only on the number of
elements, not on the number of threads, so that vectorised loops treat each element in the same way too. Results
therefore have the same bits for any number of threads. No element may read what another one writes; a GPU demands this
as well.

Two kinds of kernels run as one part: kernels with tiles, because Warp keeps the tiles of all threads in one memory, and
kernels with atomic additions, because Warp's additions on a CPU are not atomic.
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

from stitchmesh.compute.kernel import RUNS_IN_PARTS, for_arguments, kernel
from stitchmesh.compute.threads import share, thread_count

BLOCK = 64
"""Threads of a block on a GPU. Small blocks spread a swatch over the whole GPU; large scenes are not slower."""
PART = 256
"""Elements of a part, a multiple of the width of all vector instructions. In a launch of blocks a part is one block."""
PARTS_PER_THREAD = 8
"""A launch must have this many parts for each thread, so that waking the thread pays; one block is enough."""
CLOSED = 1
"""Row of the counter that is not zero while the table is closed."""

_WORK_THROUGH = """
    struct Bounds { unsigned int shape[2]; size_t size, coord_mult; };
    int* inside = counters.data;
    int* closed = inside + 16;
    // For some ten microseconds a thread looks at a counter again and again: to sleep and to wake takes longer.
    const auto becomes = [](const int* counter, int value) {
        for (int looks = 0; looks < 2000; ++looks) {
            if (__atomic_load_n(counter, __ATOMIC_SEQ_CST) == value) return true;
#if defined(__x86_64__)
            __builtin_ia32_pause();
#endif
        }
        return false;
    };
    const auto wait = [&](const int* counter, int value) {
        while (!becomes(counter, value)) ((void (*)())give_way)();
    };
    for (bool open = true; open;) {
        __atomic_fetch_add(inside, 1, __ATOMIC_SEQ_CST);
        open = !__atomic_load_n(closed, __ATOMIC_SEQ_CST);
        const long long* row = table.data;
        int* done = closed + 16;
        for (int launch = 0; open && launch < table.shape[0]; ++launch, row += 5, done += 16 * (1 + ranges)) {
            const auto run = (void (*)(Bounds*, void*))row[0];
            const long long count = row[2], lanes = row[3], size = row[4], parts = (count + size - 1) / size;
            for (int k = 0; k < ranges; ++k) {
                const int range = (thread + k) % ranges;
                const long long begin = parts * range / ranges, end = parts * (range + 1) / ranges;
                int* taken = done + 16 * (1 + range);
                int own = 0;
                while (begin + __atomic_load_n(taken, __ATOMIC_RELAXED) < end) {
                    const long long part = begin + __atomic_fetch_add(taken, 1, __ATOMIC_RELAXED);
                    if (part >= end) break;
                    const long long first = part * size, last = first + size < count ? first + size : count;
                    Bounds bounds = {{(unsigned int)last, (unsigned int)lanes}, (size_t)((last - first) * lanes), 1};
                    run(&bounds, (void*)row[1]);
                    ++own;
                }
                if (own) __atomic_fetch_add(done, own, __ATOMIC_RELEASE);
            }
            wait(done, (int)parts);
        }
        if (thread == 0) {
            __atomic_store_n(closed, 1, __ATOMIC_SEQ_CST);
            wait(inside, 1);
            for (int k = 0; k < table.shape[0] * (1 + ranges); ++k) closed[16 + 16 * k] = 0;
            open = false;
        }
        __atomic_fetch_sub(inside, 1, __ATOMIC_SEQ_CST);
        open = open && becomes(closed, 1) && becomes(closed, 0);  // the table may be opened again soon
    }
"""


@wp.func_native(_WORK_THROUGH)
def take_parts(
    table: wp.array2d(dtype=wp.int64), give_way: wp.uint64, ranges: int, thread: int,
    counters: wp.array2d(dtype=wp.int32)
):  # fmt: skip
    """Take parts of launches until none is left; ``give_way`` is the address of a function of the system."""
    ...


@kernel(tile=None)
def work_through(
    # model
    table: wp.array2d(dtype=wp.int64),
    give_way: wp.uint64,
    ranges: int,
    thread: int,
    # state in and out
    counters: wp.array2d(dtype=wp.int32),
) -> None:
    """Take parts of launches until none is left; thread 0 closes the table."""
    take_parts(table, give_way, ranges, thread, counters)


class LaunchTable:
    """Prepared launches on a CPU, which run one after another."""

    def __init__(self, launches: Sequence[wp.Launch]) -> None:
        """Make the table; the arrays and numbers that the launches name must stay the same."""
        self._launches = list(launches)
        self._arguments = [_arguments(launch) for launch in launches]
        rows = [
            [_address(launch.hooks.forward), ctypes.addressof(arguments), *_extents(launch), _part_size(launch)]
            for launch, arguments in zip(launches, self._arguments, strict=True)
        ]
        self._threads = max(useful_threads(launch) for launch in launches)
        # Integers of a line of the cache; each counter has a line of its own.
        self._counters = np.zeros((2 + len(rows) * (1 + self._threads), 16), dtype=np.int32)
        self._counters[CLOSED] = 1
        table = wp.array(rows, dtype=wp.int64, device="cpu")
        counters = wp.array(self._counters, dtype=wp.int32, device="cpu", copy=False)
        inputs = [table, wp.uint64(_give_way()), self._threads, 0, counters]
        self._work_through = wp.launch(work_through, 1, inputs, device="cpu", record_cmd=True)
        self._of_threads = [self._arguments_of(thread) for thread in range(self._threads)]

    def launch(self) -> None:
        """Run all launches."""
        self._counters[CLOSED] = 0
        try:
            share(self._work, self._threads)
        finally:
            if not self._counters[CLOSED, 0]:  # an interrupt before the work of this thread
                self._work(0)

    def _work(self, thread: int) -> None:
        """Do the work of a thread, without the preparations that ``wp.Launch.launch`` repeats at each call."""
        launch = self._work_through
        launch.hooks.forward(ctypes.byref(launch.bounds), ctypes.byref(self._of_threads[thread]))

    def _arguments_of(self, thread: int) -> ctypes.Structure:
        """The arguments of the native code for one thread."""
        self._work_through.set_param_by_name("thread", thread)
        return _arguments(self._work_through)


def _arguments(launch: wp.Launch) -> ctypes.Structure:
    """The arguments of a launch as a kernel receives them."""
    values = launch.params[1:]
    return _arguments_type(tuple(type(value) for value in values))(*values)


@functools.cache
def _arguments_type(types: tuple[Any, ...]) -> Any:
    fields = [(f"argument_{number}", kind) for number, kind in enumerate(types)]
    return type("Arguments", (ctypes.Structure,), {"_fields_": fields})


def _extents(launch: wp.Launch) -> tuple[int, int]:
    """Number of elements of a launch and 1, or its number of blocks and the threads of a block."""
    count = int(launch.bounds.shape[0])
    return count, launch.bounds.size // count


def _part_size(launch: wp.Launch) -> int:
    """How many elements or blocks of a launch form a part."""
    count, _lanes = _extents(launch)
    if not RUNS_IN_PARTS or _uses_one_memory(launch.kernel.func):
        return count
    return PART if len(launch.bounds.shape) == 1 else 1


def useful_threads(launch: wp.Launch) -> int:
    """Number of threads that the launch keeps busy, at most ``thread_count()``."""
    parts = -(-_extents(launch)[0] // _part_size(launch))
    enough_for = parts // PARTS_PER_THREAD if len(launch.bounds.shape) == 1 else parts
    return max(1, min(enough_for, thread_count()))


@functools.cache
def _uses_one_memory(function: Callable[..., Any]) -> bool:
    """Whether a function of a kernel, or one that it calls, uses tiles or atomic additions."""
    names = function.__code__.co_names
    # A kernel runs as one part if it calls a function of Warp whose name begins with one of these words
    if any(name.startswith(("tile", "atomic")) for name in names):
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


def prepare(
    kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any], device: wp.Device
) -> wp.Launch:
    """Prepare a launch that will be repeated.

    Args:
        kernel: the kernel.
        count: number of threads, or number of blocks if the kernel declares the threads of a block.
        inputs: the first arguments of the kernel.
        outputs: its last arguments.
        device: where the kernel runs.
    """
    kernel = for_arguments(kernel, [*inputs, *outputs])
    arguments: dict[str, Any] = {"inputs": inputs, "outputs": outputs, "device": device, "record_cmd": True}
    if kernel.tile:
        return wp.launch_tiled(kernel, dim=count, block_dim=kernel.tile, **arguments)
    return wp.launch(kernel, count, block_dim=BLOCK, **arguments)


def launch(
    kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any], device: wp.Device
) -> None:
    """Run a kernel once, with the arguments of ``prepare``."""
    if count == 0:
        return
    prepared = prepare(kernel, count, inputs, outputs, device)
    if device.is_cpu and useful_threads(prepared) > 1:
        prepared = LaunchTable([prepared])
    prepared.launch()
