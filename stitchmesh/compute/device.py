# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Warp's devices, on which kernels run; Warp is initialised without messages."""

from __future__ import annotations

import ctypes
import functools
import os
import sys
import threading
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

import warp as wp

from stitchmesh.errors import ParameterError

FIRST_GPU, CPU = "cuda:0", "cpu"
"""Warp's names of the first GPU and of the CPU."""
CUDA_DRIVER = "nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1"


_turn = threading.Condition()
_queue: deque[int] = deque()
"""Identifiers of the threads that launch kernels or wait for access; the first one has the access."""


@contextmanager
def alone() -> Iterator[None]:
    """Exclude all other threads from launching kernels; a context manager, or the decorator ``@alone()`` of a function.

    Warp does not support several threads: on the CPU, tile sums share one scratch memory, and on a GPU a captured graph
    contains the launches of other threads too. Threads get the exclusive access in the order of their requests. A
    thread that has the access may request it again (the lock is reentrant).
    """
    own = threading.get_ident()
    with _turn:
        within = bool(_queue) and _queue[0] == own
        if not within:
            _queue.append(own)
            try:
                _turn.wait_for(lambda: _queue[0] == own)
            except BaseException:  # After an interrupt, other threads must not wait for this thread.
                _queue.remove(own)
                _turn.notify_all()
                raise
    try:
        yield
    finally:
        if not within:
            with _turn:
                _queue.popleft()
                _turn.notify_all()


@contextmanager
def others_may_launch() -> Iterator[None]:
    """Let other threads launch kernels: a context manager for a function with ``alone()`` that waits or gives way.

    At its end the thread takes its exclusive access again, after all threads that have asked for it in between. No
    array of the thread changes, because every function works on its own arrays. Without the access, nothing happens.
    """
    own = threading.get_ident()
    with _turn:
        had = bool(_queue) and _queue[0] == own
        if had:
            _queue.popleft()
            _turn.notify_all()
    try:
        yield
    finally:
        if had:
            _take_access_again(own)


def _take_access_again(own: int) -> None:
    """Wait for the access; raise an interrupt only afterwards, because the caller's block then gives the access up."""
    interrupt: BaseException | None = None
    with _turn:
        _queue.append(own)
        while _queue[0] != own:
            try:
                _turn.wait()
            except BaseException as error:
                interrupt = error
    if interrupt is not None:
        raise interrupt


def device_named(name: str | None) -> wp.Device:
    """Return a device.

    Args:
        name: Warp's name of the device, for example ``cpu`` or ``cuda:0``. If it is None, the device is the first GPU,
            or the CPU on a machine without a GPU.

    Raises:
        ParameterError: there is no device of that name.
    """
    names = device_names()
    if name is None:
        name = FIRST_GPU if FIRST_GPU in names else CPU
    if name not in names:
        raise ParameterError(f"device: got {name!r}; expected one of {', '.join(names)}")
    return wp.get_device(name)


def device_names() -> list[str]:
    """Return Warp's names of all devices of this machine."""
    _start_warp()
    return [str(device) for device in wp.get_devices()]


@functools.cache
def _start_warp() -> None:
    """Initialise Warp without its banner, and without its warning that the machine has no GPU."""
    wp.config.log_level = wp.LOG_WARNING
    with nullcontext() if _has_driver() else _silent_standard_error():
        wp.init()


def _has_driver() -> bool:
    """Return whether the machine has a CUDA driver."""
    try:
        ctypes.CDLL(CUDA_DRIVER)
    except OSError:
        return False
    return True


@contextmanager
def _silent_standard_error() -> Iterator[None]:
    """Discard standard error on the level of the file descriptor, because native code does not use ``sys.stderr``."""
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
