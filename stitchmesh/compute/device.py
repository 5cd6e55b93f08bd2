# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where kernels run: Warp's devices, started without noise."""

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

CUDA_DRIVER = "nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1"


_turn = threading.Condition()
_queue: deque[int] = deque()
"""Threads that launch kernels or wait to; the first one does."""


@contextmanager
def alone() -> Iterator[None]:
    """Launch kernels while no other thread of the program does; a context, or with ``@alone()`` all of a function.

    Warp is not made for several threads: on the CPU, sums by tiles share one scratch memory, on a GPU a graph records
    what others launch. Threads take turns in the order in which they ask, and may ask again during their turn.
    """
    own = threading.get_ident()
    with _turn:
        within = bool(_queue) and _queue[0] == own
        if not within:
            _queue.append(own)
            try:
                _turn.wait_for(lambda: _queue[0] == own)
            except BaseException:  # interrupted: others must not wait for this thread
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


def device_named(name: str | None) -> wp.Device:
    """The device of that name; the first GPU, else the CPU, where none is named.

    Raises:
        ParameterError: there is no such device.
    """
    _start_warp()
    names = [str(device) for device in wp.get_devices()]
    if name is None:
        name = "cuda:0" if "cuda:0" in names else "cpu"
    if name not in names:
        raise ParameterError(f"device: got {name!r}; expected one of {', '.join(names)}")
    return wp.get_device(name)


@functools.cache
def _start_warp() -> None:
    """Initialise Warp without its banner, and without its warning that a machine has no GPU."""
    wp.config.log_level = wp.LOG_WARNING
    with nullcontext() if _has_driver() else _silent_standard_error():
        wp.init()


def _has_driver() -> bool:
    try:
        ctypes.CDLL(CUDA_DRIVER)
    except OSError:
        return False
    return True


@contextmanager
def _silent_standard_error() -> Iterator[None]:
    """Native code writes its warning to the file descriptor, past ``sys.stderr``."""
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
