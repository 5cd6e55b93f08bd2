# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The product of the Hessian of the energy with a motion u of the control points, and of the strains of cells.

A motion changes each leg and each gap of a pair in contact; the products with the matrices of ``segment_hessian`` and
``contact_hessian`` are gathered at the control points like forces (``evaluation``). Where a cell relaxes, the motion of
a place x is u + E x with the strain E (``cell_strain``), so that a leg or a gap g between two places changes by

    du + E g,     E g = e1 (a g1 + c g2) + e2 (b g2)

and with the product f of this change, the product for the strains is the sum of (f1 g1, f2 g2, f1 g2). The derivative
of E x by the positions is left out: it vanishes where no force is left.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block
from stitchmesh.compute.vector_loads import load_vector, store_vector
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.evaluation import leg_forces_on, sample_forces_on
from stitchmesh.yarnrelax.energies.term import Term
from stitchmesh.yarnrelax.hessian.contact_hessian import TouchingPairs
from stitchmesh.yarnrelax.hessian.segment_hessian import leg_hessian_launch
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.lattice_images import cell_of, cell_of_sample, rests, sample_number
from stitchmesh.yarnrelax.model.spline import from_entry, segment_corners, weight_row
from stitchmesh.yarnrelax.model.state import State


@wp.func
def stretched(gap: Any, e1: Any, e2: Any, strain: Any) -> Any:
    """Change of a gap by the strain (a, b, c) of its cell."""
    first, second = wp.dot(gap, e1), wp.dot(gap, e2)
    return e1 * (strain[0] * first + strain[2] * second) + e2 * (strain[1] * second)


@wp.func
def strain_part(gap: Any, e1: Any, e2: Any, pull: Any) -> Any:
    """Part of a gap with the product ``pull`` in the product for the strains."""
    first, second, along = wp.dot(gap, e1), wp.dot(gap, e2), wp.dot(pull, e1)
    return type(gap)(along * first, wp.dot(pull, e2) * second, along * second)


@functools.cache
def segment_product(cell_relaxes: bool) -> wp.Kernel:
    """The kernel of the products of segments, for cells that relax or do not."""

    @kernel
    def segment_product(
        # model
        model: Any,
        point_count: int,
        per_unit: Any,
        # state in
        points: wp.array[Any],
        leg_hessian: wp.array2d[Any],
        motion: wp.array[Any],
        # state out
        sample_motion: wp.array[Any],
        leg_product: wp.array2d[Any],
        segment_strain: wp.array[Any],
    ) -> None:
        """The product for each leg, and the motion of each contact sample, without that of the cell."""
        s = wp.tid()
        if rests(model.images, cell_of(model.images, s)):
            return
        corner = model.segment_points[s]
        u0, u1, u2, u3 = motion[corner[0]], motion[corner[1]], motion[corner[2]], motion[corner[3]]
        first = model.sample_start[s]
        count = model.sample_start[s + 1] - first
        row = weight_row(model, count, 0)
        for k in range(count):
            weight = model.sample_basis[row + k]
            u = u0 * weight[0] + u1 * weight[1] + u2 * weight[2] + u3 * weight[3]
            store_vector(sample_motion, first + k, type(sample_motion[0])(u[0], u[1], u[2], u[0] - u[0]))
        change0, change1, change2 = u1 - u0, u2 - u1, u3 - u2
        if wp.static(cell_relaxes):
            q0, q1, q2, q3 = segment_corners(model, points, s)
            cell = cell_of(model.images, s)
            e1, e2 = model.images.frame[2 * cell], model.images.frame[2 * cell + 1]
            strain = motion[point_count + cell] * per_unit
            change0 += stretched(q1 - q0, e1, e2, strain)
            change1 += stretched(q2 - q1, e1, e2, strain)
            change2 += stretched(q3 - q2, e1, e2, strain)
        h01, h02, h12 = leg_hessian[1, s], leg_hessian[2, s], leg_hessian[4, s]
        product0 = leg_hessian[0, s] * change0 + h01 * change1 + h02 * change2
        product1 = wp.transpose(h01) * change0 + leg_hessian[3, s] * change1 + h12 * change2
        product2 = wp.transpose(h02) * change0 + wp.transpose(h12) * change1 + leg_hessian[5, s] * change2
        leg_product[0, s] = product0
        leg_product[1, s] = product1
        leg_product[2, s] = product2
        if wp.static(cell_relaxes):
            part = strain_part(q1 - q0, e1, e2, product0) + strain_part(q2 - q1, e1, e2, product1)
            segment_strain[s] = part + strain_part(q3 - q2, e1, e2, product2)

    return segment_product


@functools.cache
def contact_product(cell_relaxes: bool) -> wp.Kernel:
    """The kernel of the products of samples that touch, for cells that relax or do not."""

    @kernel
    def contact_product(
        # model
        model: Any,
        point_count: int,
        per_unit: Any,
        # state in
        samples: wp.array[Any],
        touching_count: wp.array[wp.int32],
        touching: wp.array2d[wp.int32],
        stiffness: wp.array2d[Any],
        motion: wp.array[Any],
        sample_motion: wp.array[Any],
        # state out
        sample_product: wp.array[Any],
        sample_strain: wp.array[Any],
    ) -> None:
        """The product for each sample."""
        p = wp.tid()
        if rests(model.images, cell_of_sample(model.images, p)):
            return
        own = load_vector(sample_motion, p)
        total = type(own)()
        if wp.static(cell_relaxes):
            here = load_vector(samples, p)
            cell = cell_of_sample(model.images, p)
            e1, e2 = model.images.frame[2 * cell], model.images.frame[2 * cell + 1]
            strain = motion[point_count + cell] * per_unit
            part = type(strain)()
        for c in range(touching_count[p]):
            entry = touching[p, c]
            k = stiffness[p, c]
            change = own - load_vector(sample_motion, sample_number(model.images, entry))
            if wp.static(cell_relaxes):
                whole = from_entry(model.images, samples, p, here, entry)
                gap = type(strain)(whole[0], whole[1], whole[2])
                more = stretched(gap, e1, e2, strain)
                change += type(own)(more[0], more[1], more[2], own[3])
            along = k[0] * change[0] + k[1] * change[1] + k[2] * change[2]
            pull = type(own)(
                k[0] * along - k[3] * change[0], k[1] * along - k[3] * change[1], k[2] * along - k[3] * change[2],
                own[3],
            )  # fmt: skip
            total += pull
            if wp.static(cell_relaxes):
                half = type(per_unit)(0.5)
                part += strain_part(gap, e1, e2, type(strain)(pull[0], pull[1], pull[2]) * half)
        store_vector(sample_product, p, total)
        if wp.static(cell_relaxes):
            sample_strain[p] = part

    return contact_product


@kernel
def gather_product(
    # model
    model: Any,
    # state in
    leg_product: wp.array2d[Any],
    sample_product: wp.array[Any],
    # state out
    product: wp.array[Any],
) -> None:
    """The product for each control point."""
    i = wp.tid()
    slots = model.point_segments[i]
    if rests(model.images, cell_of(model.images, wp.max(slots))):
        return
    total = type(leg_product[0, 0])()
    contact = type(sample_product[0])()
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            total += leg_forces_on(leg_product, s, slot)
            contact += sample_forces_on(model, sample_product, s, slot)
    product[i] = total + type(total)(contact[0], contact[1], contact[2])


@kernel
def sum_strain_products(
    # model
    model: Any,
    blocks: int,
    cell_segments: wp.array[wp.int32],
    # state in
    segment_strain: wp.array[Any],
    sample_strain: wp.array[Any],
    # state out
    parts: wp.array3d[wp.float64],
) -> None:
    """Partial sums of the product for a cell's strains; ``blocks`` blocks for each cell."""
    number, lane = wp.tid()
    threads = wp.block_dim()
    cell = number // blocks
    if rests(model.images, cell):
        return
    block = number - cell * blocks
    first, last = cell_segments[cell], cell_segments[cell + 1]
    total = Slots()
    for s in range(first + block * threads + lane, last, blocks * threads):
        for k in range(3):
            total[k] += wp.float64(segment_strain[s][k])
    for p in range(model.sample_start[first] + block * threads + lane, model.sample_start[last], blocks * threads):
        for k in range(3):
            total[k] += wp.float64(sample_strain[p][k])
    sum_over_block(total, parts[cell, block])


@kernel
def put_strain_products(
    # model
    point_count: int,
    per_unit: wp.float64,
    free: wp.array[wp.vec3d],
    # state in
    parts: wp.array3d[wp.float64],
    # state out
    product: wp.array[Any],
) -> None:
    """The product for the strains of each cell that are free."""
    cell = wp.tid()
    total = wp.vec3d()
    for block in range(parts.shape[1]):
        total += wp.vec3d(parts[cell, block, 0], parts[cell, block, 1], parts[cell, block, 2])
    total = wp.cw_mul(total, free[cell]) * per_unit
    value = product[point_count + cell]
    product[point_count + cell] = type(value)(
        type(value[0])(total[0]), type(value[0])(total[1]), type(value[0])(total[2])
    )


@dataclass(eq=False)
class Hessian:
    """The matrices of the current state and the arrays of a product."""

    def __init__(
        self, model: Model, state: State, candidates: Candidates, strain: Any = None, terms: Sequence[Term] = ()
    ) -> None:
        """Allocate for a state; ``strain`` is the ``CellStrain`` of cells that relax."""
        relaxes = strain is not None
        self.model, self.state, self.strain = model, state, strain
        self.exact = model.empty(model.cell_count)
        """Share of the exact matrix of each cell; the rest is that of Gauss and Newton, shape (C,)."""
        matrix = wp.types.matrix(shape=(3, 3), dtype=model.scalar)
        self.leg_hessian = wp.zeros((6, model.segment_count), dtype=matrix, device=model.device)
        self.touching = TouchingPairs(model, candidates)
        self.sample_motion, self.sample_product = model.empty(model.sample_count, 4), model.empty(model.sample_count, 4)
        self.leg_product = model.empty((3, model.segment_count), 3)
        self.segment_strain = model.empty(model.segment_count if relaxes else 0, 3)
        self.sample_strain = model.empty(model.sample_count if relaxes else 0, 3)
        self.terms = terms
        self.threads = THREADS if model.device.is_cuda else 1
        blocks = strain.blocks if relaxes else 0
        self.parts = wp.zeros((model.cell_count, blocks, 7), dtype=wp.float64, device=model.device)

    def find_launches(self, launcher: Launcher) -> list[Any]:
        """The launches that find the matrices at the current points and samples."""
        return [
            leg_hessian_launch(self.model, self.exact, self.state.points, self.leg_hessian, launcher),
            self.touching.launch(self.exact, self.state.samples, launcher),
        ]

    def product_launches(self, motion: wp.array[Any], product: wp.array[Any], launcher: Launcher) -> list[Any]:
        """The launches that find the product with a motion, both of shape (E, 3)."""
        model, state, n = self.model, self.state, self.model.point_count
        relaxes, per_unit = self.strain is not None, model.number(1.0 / STRAIN_UNIT)
        constants, pairs = model.constants, self.touching
        launches = [
            launcher(segment_product(relaxes), model.segment_count,
                     [constants, n, per_unit, state.points, self.leg_hessian, motion],
                     [self.sample_motion, self.leg_product, self.segment_strain]),
            launcher(contact_product(relaxes), model.sample_count,
                     [constants, n, per_unit, state.samples, pairs.count, pairs.entries, pairs.stiffness, motion,
                      self.sample_motion], [self.sample_product, self.sample_strain]),
            launcher(gather_product, n, [constants, self.leg_product, self.sample_product],
                     [product]),
        ]  # fmt: skip
        launches += [launch for term in self.terms for launch in term.product(state, motion, product, launcher)]
        if relaxes:
            cells = model.cell_count
            inputs = [constants, self.strain.blocks, model.cell_segments, self.segment_strain, self.sample_strain]
            launches += [
                launcher(sum_strain_products, cells * self.strain.blocks, inputs, [self.parts], tile=self.threads),
                launcher(put_strain_products, cells,
                         [n, wp.float64(1.0 / STRAIN_UNIT), self.strain.free, self.parts], [product]),
            ]  # fmt: skip
        return launches
