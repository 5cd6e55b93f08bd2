# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The arrays that change during a relaxation; lengths in units (``constants``), forces in erg per unit."""

from __future__ import annotations

import functools
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import warp as wp

from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.precision import Scalar, ScalarType, Vec3, vector
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.model.constants import Model

StateArrays: TypeAlias = Any
"""The struct of the arrays of a ``State``, in either precision."""
USED_UP = wp.constant(0.7)
"""A control point asks for new candidate lists when it has used this part of its budget."""


@dataclass(frozen=True, eq=False)
class YarnForces:
    """Where terms add their forces [erg / unit]: the arrays of a state, one for each kind of place."""

    points: wp.array[Any]
    """Force on each control point, shape (N, 3)."""
    samples: wp.array[Any]
    """Force on each contact sample, and the row sum of its stiffness [erg / unit^2], shape (P, 4)."""
    blocks: wp.array[Any]
    """Stiffness at each sample, shape (P, 6), or empty."""
    virial: wp.array[Any]
    """Part of each sample in the virial of its cell and in its stiffness, shape (P, 9), or empty."""
    legs: wp.array[Any]
    """Force on the end of each of a segment's three legs, shape (3, S, 3)."""
    leg_virial: wp.array[Any]
    """Part of each segment in the virial of its cell and in its stiffness, shape (S, 9), or empty."""

    @property
    def parts(self) -> tuple[wp.array[Any]]:
        """The forces on control points."""
        return (self.points,)

    @property
    def device(self) -> wp.Device:
        """Where the arrays lie."""
        return self.points.device


@dataclass(frozen=True, eq=False)
class State:
    """Arrays that the kernels of an iteration read and write."""

    points: wp.array[Any]
    """Control points, and after them the strains of relaxing cells since the start (``cell_strain``), shape (E, 3)."""
    listed_points: wp.array[Any]
    """The entries of ``points`` at the time when the candidate lists were made, shape (E, 3)."""
    budget: wp.array[Any]
    """How far each entry may move from its listed place (``step_limit``), shape (E,)."""
    samples: wp.array[Any]
    """Contact samples: place and yarn radius, shape (P, 4)."""
    sample_force: wp.array[Any]
    """Force on each sample, and the row sum of its stiffness [erg / unit^2], shape (P, 4)."""
    sample_block: wp.array[Any]
    """Stiffness of contact at each sample as (xx, yy, zz, xy, xz, yz), shape (P, 6); empty if no solver reads it."""
    segment_block: wp.array[Any]
    """Means of t t^T and of (l / |y'|)^4 over each segment, t its unit tangent, (S, 7); empty if no solver reads it."""
    leg_force: wp.array[Any]
    """Force on the end of each of a segment's three legs, shape (3, S, 3)."""
    sample_virial: wp.array[Any]
    """Part of each sample in the virial of its cell and in its stiffness (``cell_virial``), shape
    (P, 9); empty if no cell relaxes."""
    segment_virial: wp.array[Any]
    """Part of each segment in that virial and stiffness, shape (S, 9); empty if no cell relaxes."""
    external_force: wp.array[Any]
    """Force of terms that act on control points, shape (N, 3); empty if there is no such term."""
    force: wp.array[Any]
    """Sum of all forces on each control point, and forces on the strains of cells, shape (E, 3)."""
    stiffness: wp.array[Any]
    """Row sum of stiffness at each entry [erg / unit^2], shape (E,)."""
    preconditioner: wp.array[Any]
    """Inverse block of stiffness of each entry (``preconditioner``) [unit^2 / erg], shape (E, 6); empty if no solver
    reads it."""

    @cached_property
    def forces(self) -> YarnForces:
        """The arrays to which terms add their forces."""
        return YarnForces(
            self.external_force, self.sample_force, self.sample_block, self.sample_virial, self.leg_force,
            self.segment_virial,
        )  # fmt: skip

    @property
    def parts(self) -> tuple[wp.array[Any]]:
        """The control points."""
        return (self.points,)

    @property
    def device(self) -> wp.Device:
        """Where the arrays lie."""
        return self.points.device

    @cached_property
    def arrays(self) -> Any:
        """All arrays in a struct for the fused kernel."""
        struct = _struct(self.budget.dtype)()
        for field in fields(self):
            setattr(struct, field.name, getattr(self, field.name))
        return struct

    @property
    def cell_relaxes(self) -> bool:
        """Whether cells relax."""
        return len(self.segment_virial) > 0


@wp.func
def room_left(points: wp.array[Vec3], listed_points: wp.array[Vec3], budget: wp.array[Scalar], i: int) -> Any:
    """How far control point ``i`` may still move on these candidate lists."""
    return wp.max(budget[i] - wp.length(points[i] - listed_points[i]), budget[i] - budget[i])


@wp.func
def shortened(step: Vec3, limit: Scalar) -> Any:
    """The step, no longer than the limit."""
    length = wp.length(step)
    if length > limit:
        return step * (limit / length)
    return step


@functools.cache
def _struct(scalar: ScalarType) -> Any:
    """Return the struct of a state in one precision."""
    scalars = wp.array(dtype=scalar)
    threes, fours, sixes, sevens, nines = (wp.array(dtype=vector(size, scalar)) for size in (3, 4, 6, 7, 9))
    annotations = {
        "points": threes,
        "listed_points": threes,
        "budget": scalars,
        "samples": fours,
        "sample_force": fours,
        "sample_block": sixes,
        "segment_block": sevens,
        "leg_force": wp.array2d(dtype=vector(3, scalar)),
        "sample_virial": nines,
        "segment_virial": nines,
        "external_force": threes,
        "force": threes,
        "stiffness": scalars,
        "preconditioner": sixes,
    }
    return wp.struct(type(f"YarnState_{scalar.__name__}", (), {"__annotations__": annotations}))


named_type("StateArrays", lambda form: [_struct(form.scalar)])


def make_state(
    model: Model, start: FloatArray | None = None, *, external: bool = False, blocks: bool = False, strains: int = 0
) -> State:
    """Return a state at ``start`` [cm], or at the control points of the given yarns.

    By default the arrays of external forces, of blocks of stiffness and of strains are empty; ``strains`` is the number
    of relaxing cells.
    """
    places = model.to_device(model.yarns.points if start is None else start)
    points = model.upload(np.concatenate([places, np.zeros((strains, 3))]), 3)
    n, entries = model.point_count, len(points)
    return State(
        points=points,
        listed_points=wp.clone(points),
        budget=model.empty(entries),
        samples=model.empty(model.sample_count, 4),
        sample_force=model.empty(model.sample_count, 4),
        sample_block=model.empty(model.sample_count if blocks else 0, 6),
        segment_block=model.empty(model.segment_count if blocks else 0, 7),
        leg_force=model.empty((3, model.segment_count), 3),
        sample_virial=model.empty(model.sample_count if strains else 0, 9),
        segment_virial=model.empty(model.segment_count if strains else 0, 9),
        external_force=model.empty(n if external else 0, 3),
        force=model.empty(entries, 3),
        stiffness=model.empty(entries),
        preconditioner=model.empty(entries if blocks else 0, 6),
    )
