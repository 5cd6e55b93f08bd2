# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scalar, vector and matrix types of the kernels."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.errors import ParameterError


def scalar_named(precision: str) -> Any:
    """Warp's scalar type of a precision.

    Raises:
        ParameterError: the precision is neither float32 nor float64.
    """
    scalars = {"float32": wp.float32, "float64": wp.float64}
    if precision not in scalars:
        raise ParameterError(f"precision: got {precision!r}; expected one of {', '.join(scalars)}")
    return scalars[precision]


def vector(size: int, scalar: Any) -> Any:
    """Warp's vector type of a size."""
    return wp.types.vector(length=size, dtype=scalar)


def matrix(size: int, scalar: Any) -> Any:
    """Warp's type of a square matrix."""
    return wp.types.matrix(shape=(size, size), dtype=scalar)
