# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scalar, vector and matrix types of the kernels.

Kernels and their functions have one text for both precisions, and are compiled for the types of their arguments. Python
cannot name such a type, so the names below stand for ``Any``: they say what an argument is in either precision, for
example ``Vec3`` for ``wp.vec3f`` or ``wp.vec3d``.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import warp as wp

from stitchmesh.errors import ParameterError

ScalarType: TypeAlias = Any
"""``wp.float32`` or ``wp.float64`` itself."""
Scalar: TypeAlias = Any
"""A number, ``wp.float32`` or ``wp.float64``."""
Vec2: TypeAlias = Any
"""A vector of 2 numbers."""
Vec3: TypeAlias = Any
"""A vector of 3 numbers."""
Vec4: TypeAlias = Any
"""A vector of 4 numbers."""
Vec5: TypeAlias = Any
"""A vector of 5 numbers."""
Vec6: TypeAlias = Any
"""A vector of 6 numbers."""
Vec7: TypeAlias = Any
"""A vector of 7 numbers."""
Vec9: TypeAlias = Any
"""A vector of 9 numbers."""
Vec19: TypeAlias = Any
"""A vector of 19 numbers."""
Mat22: TypeAlias = Any
"""A matrix of 2 rows and 2 columns."""
Mat33: TypeAlias = Any
"""A matrix of 3 rows and 3 columns."""
Mat44: TypeAlias = Any
"""A matrix of 4 rows and 4 columns."""
Mat46: TypeAlias = Any
"""A matrix of 4 rows and 6 columns."""


def scalar_named(precision: str) -> ScalarType:
    """Warp's scalar type of a precision.

    Raises:
        ParameterError: the precision is neither float32 nor float64.
    """
    scalars = {"float32": wp.float32, "float64": wp.float64}
    if precision not in scalars:
        raise ParameterError(f"precision: got {precision!r}; expected one of {', '.join(scalars)}")
    return scalars[precision]


def vector(size: int, scalar: ScalarType) -> Any:
    """Warp's vector type of a size."""
    return wp.types.vector(length=size, dtype=scalar)


def matrix(size: int, scalar: ScalarType) -> Any:
    """Warp's type of a square matrix."""
    return wp.types.matrix(shape=(size, size), dtype=scalar)
