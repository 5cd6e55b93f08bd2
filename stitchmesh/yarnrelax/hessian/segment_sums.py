# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums over the pairs of contact samples of each segment, and of each pair of segments that touch.

A sample p of a segment lies at the sum of w_a q_a over its control points. A pair with the stiffness K
(``PairStiffness``) therefore adds

    w_a(p) w_b(p) K  between the points a and b of the segment of p,
    - w_a(p) w_b(q) K  between a point a of the segment of p and a point b of the segment of q.

If the cell relaxes, with the basis vectors E_m of strains, the vector g between the samples changes by E_m g. The pair
then adds w_a(p) K E_m g between a point and a strain, and half of (E_m g)^T K (E_n g) between two strains. The other
half comes with the pair in the list of q. With g1 = g . e1 and g2 = g . e2, these are products of e1 and e2 with the
sums of K g1, K g2, K g1^2, K g1 g2 and K g2^2. Legs add their products in the same way.

One thread computes each sum, and adds its parts in the order of the lists.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher, ZeroArray
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import kernel_factory
from stitchmesh.compute.precision import Mat33, Vec3, Vec4, Vec6
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import basis
from stitchmesh.yarnrelax.collision.step_limit import STRAIN_UNIT
from stitchmesh.yarnrelax.energies.pair_stiffness import (
    Block64,
    PairStiffness,
    SampleStiffness,
    StiffnessOfPair,
    block_times,
    stiffness_block,
)
from stitchmesh.yarnrelax.hessian.matrix_pattern import MatrixPattern
from stitchmesh.yarnrelax.model.constants import CellConstants, Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import (
    LatticeImages,
    cell_of,
    cell_of_sample,
    exact_shift,
    image_of,
    sample_number,
)
from stitchmesh.yarnrelax.model.spline import weight_row
from stitchmesh.yarnrelax.model.upload import sample_places

FourBlocks = wp.types.matrix(shape=(4, 6), dtype=wp.float64)
"""The blocks between one control point and the four points of a segment, each symmetric."""
HALF = wp.constant(wp.float64(0.5))


@wp.func
def strain_changes(gap: wp.vec3d, e1: wp.vec3d, e2: wp.vec3d, per_unit: wp.float64) -> wp.mat33d:
    """Changes of a vector by the strains of its cell, one column for each."""
    first, second = wp.dot(gap, e1) * per_unit, wp.dot(gap, e2) * per_unit
    return wp.matrix_from_cols(e1 * first, e2 * second, e1 * second)


@wp.func
def exact_corner(model: YarnConstants, points: wp.array[Vec3], s: int, slot: int) -> wp.vec3d:
    """Place of a control point of a segment, in its image, in double precision."""
    shift = exact_shift(model.images, cell_of(model.images, s), model.images.corner_image[s][slot])
    return wp.vec3d(points[model.segment_points[s][slot]]) + shift


@wp.func
def exact_gap(images: LatticeImages, samples: wp.array[Vec4], p: int, entry: int) -> wp.vec3d:
    """Vector from a listed sample, in its image, to sample ``p`` in double precision."""
    here, there = wp.vec4d(samples[p]), wp.vec4d(samples[sample_number(images, entry)])
    apart = here - there
    shift = exact_shift(images, cell_of_sample(images, p), image_of(images, entry, images.sample_count))
    return wp.vec3d(apart[0], apart[1], apart[2]) - shift


@kernel
def sum_leg_strains(
    # model
    model: CellConstants,
    per_unit: wp.float64,
    frame: wp.array[wp.vec3d],
    # state in
    points: wp.array[Vec3],
    leg_hessian: wp.array2d[Mat33],
    # state out
    point_strains: wp.array2d[wp.mat33d],
    strain_strains: wp.array[wp.mat33d],
) -> None:
    """The parts of the legs of each segment between its points and the strains, and between two strains."""
    s = wp.tid()
    cell = cell_of(model.images, s)
    e1, e2 = frame[2 * cell], frame[2 * cell + 1]
    q0, q1 = exact_corner(model, points, s, 0), exact_corner(model, points, s, 1)
    q2, q3 = exact_corner(model, points, s, 2), exact_corner(model, points, s, 3)
    change0 = strain_changes(q1 - q0, e1, e2, per_unit)
    change1 = strain_changes(q2 - q1, e1, e2, per_unit)
    change2 = strain_changes(q3 - q2, e1, e2, per_unit)
    h01, h02, h12 = wp.mat33d(leg_hessian[1, s]), wp.mat33d(leg_hessian[2, s]), wp.mat33d(leg_hessian[4, s])
    pull0 = wp.mat33d(leg_hessian[0, s]) * change0 + h01 * change1 + h02 * change2
    pull1 = wp.transpose(h01) * change0 + wp.mat33d(leg_hessian[3, s]) * change1 + h12 * change2
    pull2 = wp.transpose(h02) * change0 + wp.transpose(h12) * change1 + wp.mat33d(leg_hessian[5, s]) * change2
    point_strains[s, 0] = -pull0
    point_strains[s, 1] = pull0 - pull1
    point_strains[s, 2] = pull1 - pull2
    point_strains[s, 3] = pull2
    strain_strains[s] = (
        wp.transpose(change0) * pull0 + wp.transpose(change1) * pull1 + wp.transpose(change2) * pull2
    )  # fmt: skip


@wp.func
def symmetric_strains(k11: Vec6, k12: Vec6, k22: Vec6, e1: wp.vec3d, e2: wp.vec3d, size: wp.float64) -> wp.mat33d:
    """The matrix of strains from the sums of K g1^2, K g1 g2 and K g2^2, times a number."""
    aa, bb = wp.dot(e1, block_times(k11, e1)) * size, wp.dot(e2, block_times(k22, e2)) * size
    cc, ab = wp.dot(e1, block_times(k22, e1)) * size, wp.dot(e1, block_times(k12, e2)) * size
    ac, bc = wp.dot(e1, block_times(k12, e1)) * size, wp.dot(e2, block_times(k22, e1)) * size
    return wp.mat33d(aa, ab, ac, ab, bb, bc, ac, bc, cc)


@kernel_factory(lambda form: [(relaxes,) for relaxes in form.relaxing])
def sum_own_pairs(cell_relaxes: bool) -> wp.Kernel:
    """Return the kernel of the sums of each segment, for cells that relax or do not."""

    @kernel
    def sum_own_pairs(
        # model
        model: YarnConstants,
        images: LatticeImages,
        weights: wp.array[wp.vec4d],
        per_unit: wp.float64,
        frame: wp.array[wp.vec3d],
        # state in
        samples: wp.array[Vec4],
        pair_count: wp.array[wp.int32],
        entries: wp.array2d[wp.int32],
        stiffness: wp.array2d[StiffnessOfPair],
        # state in and out
        own_blocks: wp.array2d[FourBlocks],
        point_strains: wp.array2d[wp.mat33d],
        strain_strains: wp.array[wp.mat33d],
    ) -> None:
        """Add the pairs of the samples of each segment to its blocks."""
        s = wp.tid()
        first, last = model.sample_start[s], model.sample_start[s + 1]
        row = weight_row(model, last - first, 0)
        own0, own1, own2, own3 = FourBlocks(), FourBlocks(), FourBlocks(), FourBlocks()
        if wp.static(cell_relaxes):
            cell = cell_of(model.images, s)
            e1, e2 = frame[2 * cell], frame[2 * cell + 1]
            pull0, pull1, pull2, pull3 = wp.mat33d(), wp.mat33d(), wp.mat33d(), wp.mat33d()
            k11, k12, k22 = Block64(), Block64(), Block64()
        for p in range(first, last):
            if pair_count[p] > 0:
                total, k1, k2 = Block64(), Block64(), Block64()
                for c in range(pair_count[p]):
                    block = stiffness_block(stiffness[p, c])
                    total += block
                    if wp.static(cell_relaxes):
                        gap = exact_gap(images, samples, p, entries[p, c])
                        g1, g2 = wp.dot(gap, e1), wp.dot(gap, e2)
                        along, across = block * g1, block * g2
                        k1 += along
                        k2 += across
                        k11 += along * g1
                        k12 += along * g2
                        k22 += across * g2
                weight = weights[row + p - first]
                blocks = wp.outer(weight, total)
                own0 += blocks * weight[0]
                own1 += blocks * weight[1]
                own2 += blocks * weight[2]
                own3 += blocks * weight[3]
                if wp.static(cell_relaxes):
                    pull = wp.matrix_from_cols(block_times(k1, e1), block_times(k2, e2), block_times(k2, e1)) * per_unit
                    pull0 += pull * weight[0]
                    pull1 += pull * weight[1]
                    pull2 += pull * weight[2]
                    pull3 += pull * weight[3]
        own_blocks[s, 0] += own0
        own_blocks[s, 1] += own1
        own_blocks[s, 2] += own2
        own_blocks[s, 3] += own3
        if wp.static(cell_relaxes):
            point_strains[s, 0] += pull0
            point_strains[s, 1] += pull1
            point_strains[s, 2] += pull2
            point_strains[s, 3] += pull3
            strain_strains[s] += symmetric_strains(k11, k12, k22, e1, e2, HALF * per_unit * per_unit)

    return sum_own_pairs


@kernel
def sum_samples(
    # model
    model: YarnConstants,
    weights: wp.array[wp.vec4d],
    # state in
    stiffness: wp.array[Vec6],
    # state in and out
    own_blocks: wp.array2d[FourBlocks],
) -> None:
    """Add w_a w_b K of the samples of each segment alone to its blocks."""
    s = wp.tid()
    first, last = model.sample_start[s], model.sample_start[s + 1]
    row = weight_row(model, last - first, 0)
    for p in range(first, last):
        weight = weights[row + p - first]
        blocks = wp.outer(weight, stiffness_block(stiffness[p]))
        for a in range(4):
            own_blocks[s, a] += blocks * weight[a]


@kernel
def sum_pairs_between(
    # model
    model: YarnConstants,
    images: LatticeImages,
    weights: wp.array[wp.vec4d],
    pairs: wp.array[wp.vec2i],
    # state in
    pair_count: wp.array[wp.int32],
    entries: wp.array2d[wp.int32],
    stiffness: wp.array2d[StiffnessOfPair],
    # state in and out
    blocks: wp.array2d[FourBlocks],
) -> None:
    """Add w_a w_b K of the pairs between two segments, for the points a of the first and b of the second."""
    number = wp.tid()
    s, t = pairs[number][0], pairs[number][1]
    first, other_first = model.sample_start[s], model.sample_start[t]
    last, other_last = model.sample_start[s + 1], model.sample_start[t + 1]
    row, other_row = weight_row(model, last - first, 0), weight_row(model, other_last - other_first, 0)
    sum0, sum1, sum2, sum3 = FourBlocks(), FourBlocks(), FourBlocks(), FourBlocks()
    for p in range(first, last):
        part = FourBlocks()
        found = int(0)
        for c in range(pair_count[p]):
            q = sample_number(images, entries[p, c])
            if q >= other_first and q < other_last:
                part += wp.outer(weights[other_row + q - other_first], stiffness_block(stiffness[p, c]))
                found += 1
        if found > 0:
            weight = weights[row + p - first]
            sum0 += part * weight[0]
            sum1 += part * weight[1]
            sum2 += part * weight[2]
            sum3 += part * weight[3]
    blocks[number, 0] += sum0
    blocks[number, 1] += sum1
    blocks[number, 2] += sum2
    blocks[number, 3] += sum3


class SegmentSums:
    """The sums on a device."""

    def __init__(self, model: Model, frame: FloatArray | None) -> None:
        """Allocate the sums; ``frame`` holds the directions e1 and e2 of relaxing cells, (C, 2, 3), or is None."""
        device, segments = model.device, model.segment_count
        relaxes = frame is not None
        self.model, self.relaxes = model, relaxes
        most = int(np.diff(model.sample_start).max())
        self._weights = wp.array(basis(sample_places(most)), dtype=wp.vec4d, device=device)
        directions = np.zeros((0, 3)) if frame is None else frame.reshape(-1, 3)
        self.frame = wp.array(directions, dtype=wp.vec3d, device=device)
        """e1 and e2 of each cell, shape (2 C, 3), or (0, 3) if no cell relaxes."""
        self.own_blocks = wp.zeros((segments, 4), dtype=FourBlocks, device=device)
        """Sums of pairs between two points of a segment, without their parts between samples, shape (S, 4, 4, 6)."""
        self.point_strains = wp.zeros((segments if relaxes else 0, 4), dtype=wp.mat33d, device=device)
        """Sums between the points of each segment and the strains of its cell, shape (S, 4, 3, 3)."""
        self.strain_strains = wp.zeros(segments if relaxes else 0, dtype=wp.mat33d, device=device)
        """What each segment adds to the sums between two strains of its cell, shape (S, 3, 3)."""
        self.blocks = wp.zeros((0, 4), dtype=FourBlocks, device=device)
        """Sums between the points of each pair of segments that touch, with the opposite sign, shape (M, 4, 4, 6)."""

    def launches(
        self, points: wp.array[Any], samples: wp.array[Any], leg_hessian: wp.array[Any],
        pairs: Sequence[PairStiffness], samples_alone: Sequence[SampleStiffness], pattern: MatrixPattern,
        launcher: Launcher,
    ) -> list[Any]:  # fmt: skip
        """Return the launches that find all sums."""
        model, count = self.model, pattern.pair_count
        constants, per_unit = model.constants, wp.float64(1.0 / float(STRAIN_UNIT))
        if len(self.blocks) != count:
            self.blocks = wp.empty((count, 4), dtype=FourBlocks, device=model.device)
        launches: list[Any] = [ZeroArray(self.own_blocks), *([ZeroArray(self.blocks)] if count else [])]
        if self.relaxes:
            launches.append(
                launcher(sum_leg_strains, model.segment_count, [constants, per_unit, self.frame, points, leg_hessian],
                         [self.point_strains, self.strain_strains])
            )  # fmt: skip
        for own in pairs:
            launches.append(
                launcher(sum_own_pairs(self.relaxes), model.segment_count,
                         [constants, own.images, self._weights, per_unit, self.frame, samples, own.count, own.entries,
                          own.stiffness], [self.own_blocks, self.point_strains, self.strain_strains])
            )  # fmt: skip
            if count:
                launches.append(
                    launcher(sum_pairs_between, count,
                             [constants, own.images, self._weights, pattern.pairs, own.count, own.entries,
                              own.stiffness], [self.blocks])
                )  # fmt: skip
        for alone in samples_alone:
            inputs = [constants, self._weights, alone.stiffness]
            launches.append(launcher(sum_samples, model.segment_count, inputs, [self.own_blocks]))
        return launches
