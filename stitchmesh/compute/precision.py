# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scalar, vector and matrix types of the kernels, and four numbers in one memory transaction.

Kernels and their functions have one text for both precisions, and are compiled for the types of their arguments. Python
cannot name such a type, so the names below stand for ``Any``: they say what an argument is in either precision, for
example ``Vec3`` for ``wp.vec3f`` or ``wp.vec3d``.

Warp's vectors are aligned like their components, so a GPU reads four floats in four transactions. Arrays of four floats
start at multiples of 256 bytes, so ``load_vector`` and ``store_vector`` move each element in one transaction. Measured,
this saves a third of the time of the contact kernel and two thirds of the time of the kernel that places samples. For
four doubles the two functions are a plain read and a plain write.
"""

# no postponed annotations: Warp evaluates the types of native functions directly
# ruff: noqa: F811
# mypy: disable-error-code="no-redef,valid-type,no-untyped-def,empty-body"

from collections.abc import Callable
from typing import Any, TypeAlias

import warp as wp

from stitchmesh.compute.kernel_variants import KernelForm, named_type
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
Number: TypeAlias = Any
"""A whole number, or a number of either precision."""
Stored: TypeAlias = Any
"""A number of single precision where that suffices, in a run of either precision."""

named_type("Scalar", lambda form: [form.scalar])
named_type("Stored", lambda form: [wp.float32, form.scalar])
named_type("Number", lambda form: [wp.int32, wp.float32, wp.float64])

_READ_FLOATS = """
#if defined(__CUDA_ARCH__)
    const float4 whole = reinterpret_cast<const float4*>(values.data)[i];
    return wp::vec_t<4, wp::float32>(whole.x, whole.y, whole.z, whole.w);
#else
    return values.data[i];
#endif
"""
_WRITE_FLOATS = """
#if defined(__CUDA_ARCH__)
    float4 whole;
    whole.x = value[0]; whole.y = value[1]; whole.z = value[2]; whole.w = value[3];
    reinterpret_cast<float4*>(values.data)[i] = whole;
#else
    values.data[i] = value;
#endif
"""


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


def _vectors_of(size: int) -> Callable[[KernelForm], list[Any]]:
    return lambda form: [vector(size, form.scalar)]


def _matrices_of(size: int) -> Callable[[KernelForm], list[Any]]:
    return lambda form: [matrix(size, form.scalar)]


for _size in (2, 3, 4, 5, 6, 7, 9, 19):
    named_type(f"Vec{_size}", _vectors_of(_size))
for _size in (2, 3, 4):
    named_type(f"Mat{_size}{_size}", _matrices_of(_size))


@wp.func_native(_READ_FLOATS)
def load_vector(values: wp.array(dtype=wp.vec4f), i: int) -> wp.vec4f:
    """Element ``i``."""
    ...


@wp.func
def load_vector(values: wp.array(dtype=wp.vec4d), i: int) -> wp.vec4d:
    """Element ``i``."""
    return values[i]


@wp.func_native(_WRITE_FLOATS)
def store_vector(values: wp.array(dtype=wp.vec4f), i: int, value: wp.vec4f):
    """Set element ``i``."""
    ...


@wp.func
def store_vector(values: wp.array(dtype=wp.vec4d), i: int, value: wp.vec4d):
    """Set element ``i``."""
    values[i] = value
