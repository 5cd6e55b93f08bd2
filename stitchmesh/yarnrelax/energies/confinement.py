# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Confinement: two frictionless, elastic planes, between which a periodic fabric lies.

Let n be the normal of the lattice, z_j = n . q_j the height of a control point over the middle plane, h the distance of
each plane from it, and l_j the rest length of yarn that the control point carries. Yarn beyond a plane is pushed back:

    E = sum over control points of  kappa l_j / 2  max(|z_j| - h, 0)^2        [erg]
    f_j = -kappa l_j max(|z_j| - h, 0) sign(z_j) n
    d2E / dq_j2 = kappa l_j n n^T where |z_j| > h, else 0

A control point carries a share of its segments, by their basis functions, as with masses (``material``). The curve lies
in the convex hull of the control points, so its heights are at most the heights of the control points.

The force is normal to the periods, and deformations of a cell (``cell_strain``) keep n and every z. The term therefore
adds nothing to the forces on the strains of a cell. The stiffness is

    kappa = STIFFNESS k_bend / r^4        [erg / cm^3]

with r the mean radius, so that the similarity of L section 6.2 stays exact: energies keep their values when lengths are
multiplied by gamma.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.optimize import brentq

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.precision import Scalar, Vec3
from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.lattice import lattice_frame
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.term import InputPowers, YarnChoice, YarnTerm
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of
from stitchmesh.yarnrelax.model.material import YarnMaterial, carried_lengths
from stitchmesh.yarnrelax.model.state import State, YarnForces

STIFFNESS = 0.1
"""Stiffness of the planes over k_bend / r^4."""


@wp.func
def excess_height(place: Vec3, normal: Vec3, half: Scalar) -> Any:
    """Signed height of a place beyond the nearer plane; 0 between the planes."""
    height = wp.dot(place, normal)
    return wp.sign(height) * wp.max(wp.abs(height) - half, half - half)


@wp.func
def confinement_energy(excess: Scalar, stiffness: Scalar) -> Any:
    """Energy [erg]; ``stiffness`` is kappa l_j."""
    return type(excess)(0.5) * stiffness * excess * excess


@wp.func
def confinement_force(excess: Scalar, stiffness: Scalar) -> Any:
    """Force along the normal [erg / unit]."""
    return -stiffness * excess


@wp.func
def confinement_curvature(excess: Scalar, stiffness: Scalar) -> Any:
    """Second derivative of the energy by the height [erg / unit^2]; a Hessian is this number times n n^T."""
    return wp.where(excess == excess - excess, stiffness - stiffness, stiffness)


@wp.struct
class Planes32:
    """Normals and half distances of the planes of each cell, single precision."""

    normal: wp.array[wp.vec3f]
    half: wp.array[wp.float32]


@wp.struct
class Planes64:
    """Normals and half distances of the planes of each cell, double precision."""

    normal: wp.array[wp.vec3d]
    half: wp.array[wp.float64]


PlaneArrays: TypeAlias = Any
"""``Planes32`` or ``Planes64``."""
named_type("PlaneArrays", lambda form: [Planes32 if form.scalar is wp.float32 else Planes64])


@wp.func
def excess_of_point(planes: Any, cell: int, place: Vec3) -> Any:
    """Signed height of a control point of a cell beyond the nearer plane."""
    normal = planes.normal[cell]
    return excess_height(place, normal, planes.half[cell])


@wp.func
def cell_of_point(model: YarnConstants, i: int) -> int:
    """The cell of a control point, from one of its segments."""
    return cell_of(model.images, wp.max(model.point_segments[i]))


@kernel
def confinement_forces(
    # model
    model: YarnConstants,
    planes: PlaneArrays,
    stiffness: wp.array[Scalar],
    # state in
    points: wp.array[Vec3],
    # state out
    external_force: wp.array[Vec3],
) -> None:
    """Add the push of the planes on each control point [erg / unit]."""
    j = wp.tid()
    cell = cell_of_point(model, j)
    excess = excess_of_point(planes, cell, points[j])
    external_force[j] += planes.normal[cell] * confinement_force(excess, stiffness[j])


@kernel
def confinement_energies(
    # model
    model: YarnConstants,
    planes: PlaneArrays,
    stiffness: wp.array[Scalar],
    # state in
    points: wp.array[Vec3],
    # state out
    point_energy: wp.array[Scalar],
) -> None:
    """Energy [erg] of each control point."""
    j = wp.tid()
    excess = excess_of_point(planes, cell_of_point(model, j), points[j])
    point_energy[j] = confinement_energy(excess, stiffness[j])


@kernel
def confinement_blocks(
    # model
    model: YarnConstants,
    planes: PlaneArrays,
    stiffness: wp.array[Scalar],
    # state in
    points: wp.array[Vec3],
    # state out
    blocks: wp.array[wp.mat33d],
) -> None:
    """The second derivatives by the coordinates of each control point."""
    j = wp.tid()
    cell = cell_of_point(model, j)
    normal = wp.vec3d(planes.normal[cell])
    curvature = confinement_curvature(excess_of_point(planes, cell, points[j]), stiffness[j])
    blocks[j] = wp.outer(normal, normal) * wp.float64(curvature)


@dataclass(frozen=True)
class Confinement(YarnChoice):
    """Two planes beside a periodic fabric, parallel to its lattice; the middle plane is the middle of the given yarns.

    Raises:
        ParameterError: the half thickness is negative, or the stiffness is not positive.
    """

    half_thickness: float
    """Height of the planes over the middle plane [cm]; control points beyond it are pushed back."""
    stiffness: float = STIFFNESS
    """Stiffness of the planes over k_bend / r^4."""
    in_free_cells = True

    def __post_init__(self) -> None:
        if not (np.isfinite(self.half_thickness) and self.half_thickness >= 0.0):
            found = f"confinement: got a half thickness of {self.half_thickness} cm"
            raise ParameterError(f"{found}; expected a number of at least 0")
        check_positive("confinement: stiffness", self.stiffness)

    def on(self, model: Model) -> YarnTerm:
        """Return the planes beside a model's yarns.

        Raises:
            ParameterError: the yarns have no lattice, or several cells are given.
        """
        if not model.on_lattice or model.cell_count != 1:
            raise ParameterError("confinement: needs the yarns of one periodic fabric; leave it out")
        return _Planes(model, [self])


@dataclass(frozen=True)
class CellConfinements(YarnChoice):
    """The planes beside each of several cells."""

    choices: tuple[Confinement | None, ...]
    """The planes of each cell; None for a cell without planes."""
    in_free_cells = True

    def on(self, model: Model) -> YarnTerm:
        """Return the planes beside the cells of a model."""
        return _Planes(model, self.choices)


def plane_pressure(planes: Confinement, yarns: YarnSet, material: YarnMaterial) -> float:
    """Return the pressure of each plane on a fabric at rest between them [dyn/cm^2].

    The middle plane lies where both planes push with equal forces.

    Args:
        planes: the planes.
        yarns: the fabric, on its lattice.
        material: material of the yarns.
    """
    assert yarns.lattice is not None
    carried = carried_lengths(yarns.rest_length, yarns.segment_points, len(yarns.points))
    stiffness = planes.stiffness * material.k_bend / float(yarns.radius.mean()) ** 4 * carried
    height, half = yarns.points @ lattice_frame(yarns.lattice.periods)[2], planes.half_thickness

    def push(middle: float, side: float) -> float:
        return float((stiffness * np.maximum(side * (height - middle) - half, 0.0)).sum())

    least, most = float(height.min()), float(height.max())
    if most - least <= 2.0 * half:
        return 0.0
    middle = brentq(lambda place: push(place, 1.0) - push(place, -1.0), least, most)
    return push(middle, 1.0) / yarns.lattice.area


class _Planes(YarnTerm):
    """Confinement on a device."""

    name = "confinement"
    gives_hessian = True

    def __init__(self, model: Model, choices: Sequence[Confinement | None]) -> None:
        cells = model.cells
        periods = np.stack([cell.yarns.lattice.periods for cell in cells if cell.yarns.lattice])
        # the material belongs to yarns whose mean radius is one unit
        stiffness = [choice.stiffness * cell.material.k_bend if choice else 0.0
                     for choice, cell in zip(choices, cells, strict=True)]  # fmt: skip
        nowhere = 1e30  # for a cell without planes
        half = [choice.half_thickness / cell.unit if choice else nowhere
                for choice, cell in zip(choices, cells, strict=True)]  # fmt: skip
        carried = carried_lengths(model.rest_length, model.yarns.segment_points, model.point_count)
        self.host_stiffness = np.repeat(stiffness, np.diff(model.point_start)) * carried
        self.model = model
        self.planes = (Planes32 if model.scalar is wp.float32 else Planes64)()
        self.planes.normal = model.upload(lattice_frame(periods)[:, 2], 3)
        self.planes.half = model.upload(np.array(half))
        self.own_stiffness = model.upload(self.host_stiffness)
        self._energy = model.empty(model.point_count)
        self._blocks = wp.zeros(model.point_count, dtype=wp.mat33d, device=model.device)

    def forces(self, state: State, force: YarnForces, launcher: Launcher) -> list[Any]:
        """Return the launch that adds the push of the planes to the forces on control points."""
        inputs = [*self._constants, state.points]
        return [launcher(confinement_forces, self.model.point_count, inputs, [force.points])]

    def point_blocks(self, state: State) -> wp.array[Any]:
        """Return the stiffness of the planes at the control points beyond them, matrices (N,)."""
        self.model.launch(confinement_blocks, len(self._blocks), [*self._constants, state.points], [self._blocks])
        return self._blocks

    def element_energies(self, state: State, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """Return the launch that finds the energy of each control point, and the array of the energies."""
        inputs = [*self._constants, state.points]
        return [launcher(confinement_energies, len(self._energy), inputs, [self._energy])], self._energy

    def stiffness(self) -> NDArray[np.float64]:
        """The second derivative at a control point beyond a plane, shape (N,)."""
        return self.host_stiffness

    def input_powers(self) -> list[InputPowers]:
        """Half the distance of the planes, and their stiffness at each control point, kappa l_j."""
        return [
            InputPowers(self.planes.half, [{"planes": 1.0}]),
            InputPowers(self.own_stiffness, [{"loop_length": 1.0, "k_bend": 1.0, "radius": -4.0}]),
        ]

    @property
    def _constants(self) -> list[Any]:
        return [self.model.constants, self.planes, self.own_stiffness]
