# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stiffness of pairs of contact samples, and of single samples, which energies hand to the Hessian.

A pair has the energy E(g) of the vector g between its samples, and the symmetric matrix K of its second derivatives
[erg / unit^2]. K is stored as six numbers (xx, yy, zz, xy, xz, yz). If K = a a^T - b I, as in contact
(``contact_hessian``), it is stored as the vector a and the number b. The energy of a sample beside a body also has such
a matrix, of the derivatives by its place. Sums are always in double precision, whatever the precision of the energies.
"""

# overloads, which Warp distinguishes by the types of their arguments
# ruff: noqa: F811
# mypy: disable-error-code="no-redef,valid-type"

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, TypeAlias

import warp as wp

from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.precision import Vec6, vector

Block32, Block64 = vector(6, wp.float32), vector(6, wp.float64)


@dataclass(frozen=True, eq=False)
class PairStiffness:
    """Pairs of contact samples on a device, with the stiffness of each pair; both samples of a pair list it."""

    images: Any
    """The images that the entries refer to, with the current periods."""
    count: wp.array[Any]
    """Number of pairs of each sample, shape (P,)."""
    entries: wp.array[Any]
    """The other samples as entries of a candidate list, shape (P, capacity)."""
    stiffness: wp.array[Any]
    """Stiffness of each pair, vectors of four or of six numbers, shape (P, capacity)."""
    launches: list[Any] = field(default_factory=list)
    """The launches that find the pairs and their stiffness for the current samples."""


@dataclass(frozen=True, eq=False)
class SampleStiffness:
    """The stiffness of single contact samples, on a device."""

    stiffness: wp.array[Any]
    """Six numbers of each sample [erg / unit^2], shape (P,)."""
    launches: list[Any] = field(default_factory=list)
    """The launches that find the stiffness for the current samples."""


StiffnessOfPair: TypeAlias = Any
"""The stiffness of a pair of samples: four numbers of a contact, or the six numbers of K."""
named_type("StiffnessOfPair", lambda form: [vector(4, form.scalar), vector(6, form.scalar)])


@wp.func
def stiffness_block(stiffness: wp.vec4d) -> Block64:
    """K of a pair as six numbers, from the vector a and the number b."""
    a0, a1, a2, b = stiffness[0], stiffness[1], stiffness[2], stiffness[3]
    return Block64(a0 * a0 - b, a1 * a1 - b, a2 * a2 - b, a0 * a1, a0 * a2, a1 * a2)


@wp.func
def stiffness_block(stiffness: wp.vec4f) -> Block64:
    """K of a pair as six numbers, from the vector a and the number b."""
    return stiffness_block(wp.vec4d(stiffness))


@wp.func
def stiffness_block(stiffness: Block64) -> Block64:
    """K of a pair as six numbers."""
    return stiffness


@wp.func
def stiffness_block(stiffness: Block32) -> Block64:
    """K of a pair as six numbers."""
    return Block64(stiffness)


@wp.func
def block_times(block: Vec6, other: wp.vec3d) -> wp.vec3d:
    """The product of a symmetric matrix of six numbers with a vector."""
    x, y, z = other[0], other[1], other[2]
    return wp.vec3d(
        block[0] * x + block[3] * y + block[4] * z,
        block[3] * x + block[1] * y + block[5] * z,
        block[4] * x + block[5] * y + block[2] * z,
    )


@wp.func
def block_as_matrix(block: Vec6) -> wp.mat33d:
    """A symmetric matrix of six numbers as nine."""
    return wp.mat33d(block[0], block[3], block[4], block[3], block[1], block[5], block[4], block[5], block[2])
