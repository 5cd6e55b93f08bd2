# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Shape preservation: a garment keeps its shape while its stitches settle (Y section 6.3, eqs 5 to 7).

A loop S_j is the set of all control points of one stitch face. Loops at the border of the fabric keep their mean
position (``borders``, eq 5). Inside, patches of loops are held softly. The weight w_jk is largest at the patch's centre
and falls linearly. With

    v_k = sum over S_j in P_k, i in S_j of w_jk (q_i - q0_i),    W_k = the same sum of w_jk

and the mean displacement a = v_k / W_k, whose part along the fabric's normal n_k is a_n,

    E_k = W_k [ kappa_T |a - a_n n_k|^2 + kappa_N a_n^2 + (kappa_S - kappa_N) max(|a_n| - h, 0)^2 ]      [erg]

which is eq 6 with a normal stiffness that increases linearly from kappa_N beyond h, one yarn radius.

Patches: a face becomes a centre unless there is already one within half of RINGS. A patch reaches RINGS sides far from
its centre, and w = 1 - sides / (RINGS + 1).

Stiffness: the force of one stitch at a strain of one hundredth, bent to a loop of four radii, is

    F = 0.02 k_len / l0 + 2 k_bend / (4 r)^2        [dyn]

(l0 is ``segment_length`` of the material). If a stitch is displaced by one radius, the patches pull it back with
TANGENTIAL F along the fabric and NORMAL F across it, and with STIFFENED times NORMAL F per radius beyond one radius.
The stitches thus move by a fraction of a radius under forces that would move the garment by many radii. F scales with
the radius like all forces of the material, so the similarity of L section 6.2 stays exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csr_array, kron

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3, vector
from stitchmesh.mesh import StitchMesh
from stitchmesh.yarnrelax.energies.shape_patches import Loops, WeightedRows, choose_patches, loops_of, owners
from stitchmesh.yarnrelax.energies.term import Coupling, YarnChoice, YarnTerm
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State, YarnForces

TANGENTIAL = 0.25
"""Restoring force along the fabric at a displacement of one radius, over F."""
NORMAL = 1.0
"""Restoring force across the fabric at a displacement of one radius, over F."""
STIFFENED = 10.0
"""Normal stiffness beyond a displacement of one radius, over the normal stiffness before it."""


@wp.func
def patch_energy(mean: Vec3, normal: Vec3, stiffness: Vec3, threshold: Scalar) -> Any:
    """Energy [erg] for one unit of weight; ``stiffness`` is (kappa_T, kappa_N, kappa_S)."""
    across = wp.dot(mean, normal)
    along = mean - normal * across
    beyond = wp.max(wp.abs(across) - threshold, type(across)(0.0))
    stiffening = (stiffness[2] - stiffness[1]) * beyond * beyond
    return stiffness[0] * wp.dot(along, along) + stiffness[1] * across * across + stiffening


@wp.func
def patch_slope(mean: Vec3, normal: Vec3, stiffness: Vec3, threshold: Scalar) -> Any:
    """Derivative of the energy by the mean displacement."""
    across = wp.dot(mean, normal)
    along = mean - normal * across
    beyond = wp.max(wp.abs(across) - threshold, type(across)(0.0)) * wp.sign(across)
    push = stiffness[1] * across + (stiffness[2] - stiffness[1]) * beyond
    return (along * stiffness[0] + normal * push) * type(across)(2.0)


@kernel
def displace_loops(
    # model
    loop_start: wp.array[wp.int32],
    loop_points: wp.array[wp.int32],
    home: wp.array[Vec3],
    # state in
    points: wp.array[Vec3],
    # state out
    displacement: wp.array[Vec3],
) -> None:
    """Sum of the displacements of each loop's control points."""
    loop = wp.tid()
    total = type(points[0])()
    for k in range(loop_start[loop], loop_start[loop + 1]):
        total += points[loop_points[k]] - home[loop_points[k]]
    displacement[loop] = total


@kernel
def pull_patches(
    # model
    patch_start: wp.array[wp.int32],
    patch_loops: wp.array[wp.int32],
    patch_weight: wp.array[Scalar],
    whole: wp.array[Scalar],
    normal: wp.array[Vec3],
    stiffness: Vec3,
    threshold: Scalar,
    # state in
    displacement: wp.array[Vec3],
    # state out
    pull: wp.array[Vec3],
    energy: wp.array[Scalar],
) -> None:
    """Derivative of each patch's energy by a loop's displacement, at weight one; its energy [erg]."""
    patch = wp.tid()
    mean = type(normal[0])()
    for k in range(patch_start[patch], patch_start[patch + 1]):
        mean += displacement[patch_loops[k]] * patch_weight[k]
    mean = mean / whole[patch]
    pull[patch] = patch_slope(mean, normal[patch], stiffness, threshold)
    energy[patch] = patch_energy(mean, normal[patch], stiffness, threshold) * whole[patch]


@kernel
def add_shape_forces(
    # model
    loop_start: wp.array[wp.int32],
    loop_points: wp.array[wp.int32],
    owner_start: wp.array[wp.int32],
    owner_patches: wp.array[wp.int32],
    owner_weight: wp.array[Scalar],
    # state in
    pull: wp.array[Vec3],
    # state out
    external_force: wp.array[Vec3],
) -> None:
    """Add the pull of all patches of a loop to its control points."""
    loop = wp.tid()
    total = type(pull[0])()
    for k in range(owner_start[loop], owner_start[loop + 1]):
        total += pull[owner_patches[k]] * owner_weight[k]
    for k in range(loop_start[loop], loop_start[loop + 1]):
        external_force[loop_points[k]] -= total


@dataclass(frozen=True, eq=False)
class KeepShape(YarnChoice):
    """A garment keeps its shape (Y section 6.3, eqs 6 and 7)."""

    fabric: StitchMesh
    """The fabric from which the yarns were generated."""

    def on(self, model: Model) -> Shape:
        """Choose patches on the fabric, and send them to the device of a model.

        Raises:
            ParameterError: the yarns were not generated from this fabric.
        """
        return put_shape(model, self.fabric, loops_of(model.yarns, self.fabric))


@dataclass(frozen=True, eq=False)
class Shape(YarnTerm):
    """Loops, patches and their reference positions on the device; lengths in units."""

    name = "shape"
    gives_hessian, keeps_stitches = True, True
    model: Model
    loop_start: wp.array[Any]
    """Where each loop's control points start, shape (L + 1,)."""
    loop_points: wp.array[Any]
    """Control points of the loops."""
    home: wp.array[Any]
    """Control points at the start, shape (N, 3)."""
    patch_start: wp.array[Any]
    """Where each patch's loops start, shape (K + 1,)."""
    patch_loops: wp.array[Any]
    """Loops of the patches."""
    patch_weight: wp.array[Any]
    """Tent weights of the loops in the patches."""
    owner_start: wp.array[Any]
    """Where each loop's patches start, shape (L + 1,)."""
    owner_patches: wp.array[Any]
    """Patches of the loops."""
    owner_weight: wp.array[Any]
    """Tent weights, in the order of the owners."""
    whole: wp.array[Any]
    """Sum of each patch's weights over its control points, shape (K,)."""
    centre: NDArray[np.int64]
    """Stitch face at each patch's centre, shape (K,)."""
    normal: wp.array[Any]
    """Normal of the fabric at each patch's centre, shape (K, 3)."""
    kappa: tuple[float, float, float]
    """kappa_T, kappa_N, kappa_S [erg / unit^2]."""
    threshold: Any
    """Displacement from which the normal stiffness is larger."""
    displacement: wp.array[Any]
    """Sum of displacements of each loop, shape (L, 3)."""
    pull: wp.array[Any]
    """Pull of each patch, shape (K, 3)."""
    patch_energy: wp.array[Any]
    """Energy of each patch [erg], shape (K,)."""

    def forces(self, state: State, force: YarnForces, launcher: Launcher) -> list[Any]:
        """Add the patches' forces."""
        owned = [self.loop_start, self.loop_points, self.owner_start, self.owner_patches, self.owner_weight]
        launches = self._pull(state, launcher)
        launches.append(
            launcher(add_shape_forces, len(self.loop_start) - 1, [*owned, self.pull], [force.points])
        )
        return launches

    def element_energies(self, state: State, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """Return the launches that find the energy of each patch, and the array of the energies."""
        return self._pull(state, launcher), self.patch_energy

    def coupling(self, state: State) -> Coupling:
        """Return the coupling of the patches, whose rows sum the weighted coordinates of their control points."""
        count = len(self.whole)
        whole, normal = (array.numpy().astype(np.float64) for array in (self.whole, self.normal))
        across = np.einsum("ki,ki->k", self._of_loops @ self.displacement.numpy().astype(np.float64), normal)
        tangent, first, stiffened = self.kappa
        level = np.where(np.abs(across) > float(self.threshold) * whole, stiffened, first)
        outer = normal[:, :, None] * normal[:, None, :]
        give = outer / level[:, None, None] + (np.eye(3) - outer) / tangent
        blocks = 0.5 * whole[:, None, None] * give
        compliance = bsr_array((blocks, np.arange(count), np.arange(count + 1)), shape=(3 * count, 3 * count))
        return Coupling(self._rows, csr_array(compliance))

    @cached_property
    def _of_loops(self) -> csr_array:
        """Weights of the loops in the patches, shape (K, L)."""
        shape = len(self.whole), len(self.loop_start) - 1
        weights = self.patch_weight.numpy().astype(np.float64)
        return csr_array((weights, self.patch_loops.numpy(), self.patch_start.numpy()), shape)

    @cached_property
    def _rows(self) -> csr_array:
        """Weights of the coordinates of all control points in the coordinates of the patches, shape (3 K, 3 N)."""
        points, shape = self.loop_points.numpy(), (len(self.loop_start) - 1, len(self.home))
        of_points = csr_array((np.ones(len(points)), points, self.loop_start.numpy()), shape)
        return csr_array(kron(self._of_loops @ of_points, np.eye(3)))

    def stiffness(self) -> NDArray[np.float64]:
        """Largest row sums of the patches' stiffness."""
        start, weight = self.owner_start.numpy(), self.owner_weight.numpy().astype(np.float64)
        rows = 2.0 * max(self.kappa) * np.add.reduceat(weight, start[:-1])
        result = np.zeros(self.model.point_count)
        result[self.loop_points.numpy()] = np.repeat(rows, np.diff(self.loop_start.numpy()))
        return result

    def _pull(self, state: State, launcher: Launcher) -> list[Any]:
        kappa = vector(3, self.model.scalar)(*self.kappa)
        inputs = [self.patch_start, self.patch_loops, self.patch_weight, self.whole, self.normal, kappa,
                  self.threshold, self.displacement]  # fmt: skip
        loops = [self.loop_start, self.loop_points, self.home, state.points]
        return [
            launcher(displace_loops, len(self.loop_start) - 1, loops, [self.displacement]),
            launcher(pull_patches, len(self.whole), inputs, [self.pull, self.patch_energy]),
        ]  # fmt: skip


def put_shape(model: Model, fabric: StitchMesh, loops: Loops) -> Shape:
    """Choose patches on the fabric and send them to the device."""
    patches, centres = choose_patches(fabric, loops)
    by_loop = owners(patches, len(loops.face))
    normal = fabric.face_vector_area[centres]
    whole = np.add.reduceat(patches.weight * np.diff(loops.points.start)[patches.entry], patches.start[:-1])
    return Shape(
        model=model,
        loop_start=model.integers(loops.points.start),
        loop_points=model.integers(loops.points.entry),
        home=model.upload(model.to_device(model.yarns.points), 3),
        patch_start=model.integers(patches.start),
        patch_loops=model.integers(patches.entry),
        patch_weight=model.upload(patches.weight),
        owner_start=model.integers(by_loop.start),
        owner_patches=model.integers(by_loop.entry),
        owner_weight=model.upload(by_loop.weight),
        whole=model.upload(whole),
        centre=centres,
        normal=model.upload(normal / np.linalg.norm(normal, axis=1, keepdims=True), 3),
        kappa=_stiffness(model, loops, by_loop),
        threshold=model.number(1.0),
        displacement=model.empty(len(loops.face), 3),
        pull=model.empty(len(centres), 3),
        patch_energy=model.empty(len(centres)),
    )


def _stiffness(model: Model, loops: Loops, by_loop: WeightedRows) -> tuple[float, float, float]:
    """Return kappa_T, kappa_N and kappa_S [erg / unit^2] from the pull on one stitch; the unit is the mean radius."""
    pull = 0.02 * model.material.k_len / model.material.segment_length + 2 * model.material.k_bend / 4**2
    # a displacement of one radius gives a stitch 2 kappa radius (its control points) (the weights on it)
    points_per_stitch = len(loops.points.entry) / len(loops.face)
    weight_per_stitch = by_loop.weight.sum() / len(loops.face)
    unit = pull / (2 * points_per_stitch * weight_per_stitch)
    return TANGENTIAL * unit, NORMAL * unit, STIFFENED * NORMAL * unit
