# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Two rigid, frictionless plates that squeeze a periodic fabric, as in a test of thickness against pressure.

Yarn that is pressed against a plate is as high as yarn that is pressed against its mirror image: the plate lies in the
middle. If the axis of a yarn of radius r is rho r from the plate, the plate therefore presses with the force of two
parallel yarns whose axes are rho diameters apart (``pressure_of_parallel_yarns``), over the length l_j of yarn that a
control point carries:

    F_j = k_contact l_j g(rho)        [dyn],    g = 0 for rho >= 1
    van-wyk:  g = rho^-3 - 4 + 3 rho
    stiff:    g = 2 s / rho + 2 arccos(rho) / rho^2 - 4 rho s,    s = sqrt(1 - rho^2)

The energy is k_contact l_j r times the integral of g from rho to 1, and the second derivative k_contact l_j / r times
-g'. Heights are those of the control points, which lie farther out than the axis, by a sixth of the squared length of a
segment times its curvature. The thickness at a pressure is too large by twice that, a quarter of it with twice as many
control points. A control point beyond a plate is pushed as if rho were ``LEAST_HEIGHT``.

Plates hold the distance that they are given. The pressure is the force over the area of the cell, and both plates press
with the same force if the fabric rests between them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec2, Vec3
from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.lattice import lattice_frame
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.term import YarnChoice, YarnTerm
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.material import YarnMaterial, carried_lengths
from stitchmesh.yarnrelax.model.state import State, YarnForces

LEAST_HEIGHT = 0.05
"""Smallest distance from a plate that the law sees, in yarn radii."""


@wp.func
def soft_plate(rho: Scalar) -> tuple[Any, Any, Any]:
    """Integral of g from rho to 1, g, and -g', by van Wyk's law."""
    half, three, four = type(rho)(0.5), type(rho)(3.0), type(rho)(4.0)
    inverse = type(rho)(1.0) / rho
    inverse2 = inverse * inverse
    energy = half * inverse2 + four * rho - three * half * rho * rho - three
    return energy, inverse2 * inverse - four + three * rho, three * inverse2 * inverse2 - three


@wp.func
def stiff_plate(rho: Scalar) -> tuple[Any, Any, Any]:
    """Integral of g from rho to 1, g, and -g', by the law of Kaldor."""
    one, two, four = type(rho)(1.0), type(rho)(2.0), type(rho)(4.0)
    s = wp.sqrt(wp.max(one - rho * rho, rho - rho))
    angle, inverse = wp.atan2(s, rho), one / rho
    inverse2 = inverse * inverse
    energy = two * inverse * angle + two * (rho * rho - two) * s + two / type(rho)(3.0) * s * s * s
    push = two * s * inverse + two * angle * inverse2 - four * rho * s
    return energy, push, type(rho)(8.0) * s + four * s * inverse2 + four * angle * inverse2 * inverse


@wp.func
def push_of_plate(height: Scalar, half: Scalar, radius: Scalar, soft: int) -> tuple[Any, Any, Any]:
    """The three numbers of the law for an axis at a height over the middle plane; zeros without contact."""
    rho = (half - wp.abs(height)) / radius
    none = rho - rho
    energy, push, stiff = none, none, none
    if rho < type(rho)(1.0):
        held = wp.max(rho, type(rho)(LEAST_HEIGHT))
        if soft != 0:
            energy, push, stiff = soft_plate(held)
        else:
            energy, push, stiff = stiff_plate(held)
        energy += push * (held - rho)
    return energy, push, stiff


@kernel
def plate_forces(
    # model
    normal: wp.array[Vec3],
    half: wp.array[Scalar],
    carried: wp.array[Vec2],
    soft: int,
    # state in
    points: wp.array[Vec3],
    # state out
    external_force: wp.array[Vec3],
) -> None:
    """Add the push of the plates on each control point [erg / unit]; ``carried`` is k_contact l_j and the radius."""
    j = wp.tid()
    height = wp.dot(points[j], normal[0])
    _energy, push, _stiff = push_of_plate(height, half[0], carried[j][1], soft)
    external_force[j] += normal[0] * (-wp.sign(height) * push * carried[j][0])


@kernel
def plate_energies(
    # model
    normal: wp.array[Vec3],
    half: wp.array[Scalar],
    carried: wp.array[Vec2],
    soft: int,
    # state in
    points: wp.array[Vec3],
    # state out
    point_energy: wp.array[Scalar],
) -> None:
    """Energy [erg] of each control point."""
    j = wp.tid()
    energy, _push, _stiff = push_of_plate(wp.dot(points[j], normal[0]), half[0], carried[j][1], soft)
    point_energy[j] = energy * carried[j][0] * carried[j][1]


@kernel
def plate_blocks(
    # model
    normal: wp.array[Vec3],
    half: wp.array[Scalar],
    carried: wp.array[Vec2],
    soft: int,
    # state in
    points: wp.array[Vec3],
    # state out
    blocks: wp.array[wp.mat33d],
) -> None:
    """The second derivatives by the coordinates of each control point."""
    j = wp.tid()
    _energy, _push, stiff = push_of_plate(wp.dot(points[j], normal[0]), half[0], carried[j][1], soft)
    across = wp.vec3d(normal[0])
    blocks[j] = wp.outer(across, across) * wp.float64(stiff * carried[j][0] / carried[j][1])


@dataclass(frozen=True)
class Plates(YarnChoice):
    """Two plates beside a periodic fabric, parallel to its lattice; their middle is the middle of the given yarns.

    Raises:
        ParameterError: the distance is not a positive number.
    """

    distance: float
    """Distance of the plates: the thickness of the fabric [cm]."""
    in_free_cells = True

    def __post_init__(self) -> None:
        check_positive("plates: distance", self.distance, "cm")

    def on(self, model: Model) -> YarnTerm:
        """Return the plates beside a model's yarns.

        Raises:
            ParameterError: the yarns have no lattice, several cells are given, or the material has no contact.
        """
        if not model.on_lattice or model.cell_count != 1:
            raise ParameterError("plates: need the yarns of one periodic fabric; leave them out")
        if model.material.k_contact == 0.0:
            raise ParameterError("plates: got a material of k_contact 0, from which their push comes; raise it")
        return _PlatesTerm(model, self)


def plates_pressure(distance: float, yarns: YarnSet, material: YarnMaterial) -> float:
    """Return the pressure of each plate on a fabric at rest between them [dyn/cm^2]: the mean of both.

    Args:
        distance: distance of the plates [cm]; their middle is at the height 0 over the lattice.
        yarns: the fabric, on its lattice.
        material: material of the yarns.
    """
    assert yarns.lattice is not None
    carried = carried_lengths(yarns.rest_length, yarns.segment_points, len(yarns.points))
    height = np.abs(yarns.points @ lattice_frame(yarns.lattice.periods)[2])
    rho = np.clip((distance / 2.0 - height) / yarns.radius[yarns.point_yarn], LEAST_HEIGHT, 1.0)
    s = np.sqrt(1.0 - rho**2)
    soft = rho**-3 - 4.0 + 3.0 * rho
    push = soft if material.compression == "van-wyk" else 2 * s / rho + 2 * np.arccos(rho) / rho**2 - 4 * rho * s
    return float((material.k_contact * carried * push).sum()) / 2.0 / yarns.lattice.area


class _PlatesTerm(YarnTerm):
    """Plates on a device."""

    name = "plates"
    gives_hessian = True

    def __init__(self, model: Model, plates: Plates) -> None:
        [cell] = model.cells
        assert cell.yarns.lattice is not None
        carried = carried_lengths(model.rest_length, model.yarns.segment_points, model.point_count)
        radius = model.radius[model.yarns.point_yarn]
        # the material belongs to yarns whose mean radius is one unit
        stiffness = cell.material.k_contact * carried
        self.model = model
        self._soft = int(cell.material.compression == "van-wyk")
        self._normal = model.upload(lattice_frame(cell.yarns.lattice.periods)[None, 2], 3)
        self._half = model.upload(np.array([plates.distance / 2.0 / cell.unit]))
        self._carried = model.upload(np.column_stack([stiffness, radius]), 2)
        # yarn of van Wyk's law that is pressed to nine tenths of its height
        self._stiffness = 3.0 * (0.9**-4 - 1.0) * stiffness / radius
        self._energy = model.empty(model.point_count)
        self._blocks = wp.zeros(model.point_count, dtype=wp.mat33d, device=model.device)

    def forces(self, state: State, force: YarnForces, launcher: Launcher) -> list[Any]:
        """Return the launch that adds the push of the plates to the forces on control points."""
        return [launcher(plate_forces, self.model.point_count, self._inputs(state), [force.points])]

    def point_blocks(self, state: State) -> wp.array[Any]:
        """Return the stiffness of the plates at the control points that they press, matrices (N,)."""
        self.model.launch(plate_blocks, len(self._blocks), self._inputs(state), [self._blocks])
        return self._blocks

    def element_energies(self, state: State, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """Return the launch that finds the energy of each control point, and the array of the energies."""
        return [launcher(plate_energies, len(self._energy), self._inputs(state), [self._energy])], self._energy

    def stiffness(self) -> NDArray[np.float64]:
        """The second derivative at a control point that a plate presses, shape (N,)."""
        return self._stiffness

    def _inputs(self, state: State) -> list[Any]:
        return [self._normal, self._half, self._carried, self._soft, state.points]
