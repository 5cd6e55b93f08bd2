# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the kernels run, and in which precision."""

from __future__ import annotations

import functools
from typing import Any

import warp as wp

from stitchmesh.errors import ParameterError


@functools.cache
def start_warp() -> None:
    """Initialise Warp without its banner."""
    wp.config.log_level = wp.LOG_WARNING
    wp.init()


def device_named(name: str | None) -> wp.Device:
    """The device of that name; the first GPU, else the CPU, where none is named.

    Raises:
        ParameterError: there is no such device.
    """
    start_warp()
    names = [str(device) for device in wp.get_devices()]
    if name is None:
        name = "cuda:0" if "cuda:0" in names else "cpu"
    if name not in names:
        raise ParameterError(f"device: got {name!r}; expected one of {', '.join(names)}")
    return wp.get_device(name)


def scalar_named(precision: str) -> Any:
    """Warp's scalar type of that precision.

    Raises:
        ParameterError: the precision is neither float32 nor float64.
    """
    scalars = {"float32": wp.float32, "float64": wp.float64}
    if precision not in scalars:
        raise ParameterError(f"precision: got {precision!r}; expected one of {', '.join(scalars)}")
    return scalars[precision]


def vector(size: int, scalar: Any) -> Any:
    """Warp's vector type of that size."""
    return wp.types.vector(length=size, dtype=scalar)
