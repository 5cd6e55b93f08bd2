# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Takes the state of a run over into another region.

Positions and velocities move as in ``placement.moved_state``, and the memory of terms as in
``placement.carried_terms``. Attached nodes and vertices go to the place that their attachment prescribes, and the
hybrid nodes and vertices around them follow: attached nodes that begin on a triangle with a free corner are not at this
place.

*Momentum.* When a region grows or shrinks, mass moves between vertices and nodes. Their velocities are interpolated, so
the momentum changes a little. A rigid motion (a, w) is therefore added to the velocities of all free coordinates. It is
chosen so that both momenta, linear and angular about the centre c of the vertices, are the same as before the change:

    sum over all masses of  M (u + a + w x (x - c))  =  P,    of  (x - c) x M (u + a + w x (x - c))  =  L.

Fixed coordinates keep their velocity, and hybrid nodes move with their triangles.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.assembly import Loads, MixedFabric, contact_points, loaded_system
from stitchmesh.mixed.contact.motion import Attachment, PrescribedMotion
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.vector_sums import choose, set_sum
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.layout.spline_yarns import SplineYarns
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.placement.carried_terms import SLIDING, NodeMemory, RegionChange, carry_terms
from stitchmesh.mixed.placement.moved_state import move_state
from stitchmesh.mixed.term import MixedTerm


def moved_positions(fabric: MixedFabric, change: RegionChange, positions: MixedVector) -> MixedVector:
    """Return positions for another region.

    Args:
        fabric: cloth and yarns.
        change: the region of the positions and the region of the result. New nodes have the Eulerian coordinates of its
            memory, or of the layout.
        positions: positions [cm].
    """
    stands_out = isinstance(fabric.yarns, SplineYarns)
    above = partial(fabric.yarns.world, fabric.cloth) if stands_out else None
    return _moved(change, positions, change.memory.recalled(SLIDING, fabric.yarns.rest_sliding), above)


def moved_velocities(fabric: MixedFabric, change: RegionChange, velocities: MixedVector) -> MixedVector:
    """Return velocities for another region [cm/s]; the arguments are the same as for ``moved_positions``."""
    return _moved(change, velocities, np.zeros_like(fabric.yarns.rest_sliding), None)


def _moved(
    change: RegionChange,
    vector: MixedVector,
    rest_sliding: FloatArray,
    above: Callable[[FloatArray], FloatArray] | None,
) -> MixedVector:
    state = move_state(change.old, change.new, *vector.numpy(), rest_sliding, above)
    return MixedVector.from_numpy(state.vertices, state.nodes, state.sliding, vector.scalar, vector.device)


def region_change(fabric: MixedFabric, old: Region, new: Region, memory: NodeMemory, loads: Loads) -> RegionChange:
    """Return both regions of a fabric, with the memory of nodes and the contact points that they have under loads."""
    if not loads.bodies:
        return RegionChange(old, new, memory)
    points = [contact_points(fabric, region, loads.thickness)[0] for region in (old, new)]
    return RegionChange(old, new, memory, *points)


def settle_changed(
    fabric: MixedFabric,
    change: RegionChange,
    loads: Loads,
    old_terms: Sequence[MixedTerm],
    positions: MixedVector,
    time_step: float,
) -> None:
    """Let nodes that begin on triangles, and vertices that begin at yarns, move towards their equilibrium.

    The yarns of nodes on flat triangles are bent at the sides of triangles, and stretched like a whole triangle;
    vertices that yarns place stretch their triangles. A step in time from rest removes the energy of this before the
    motion makes waves of it. The step has no gravity, which moves everything together. Nodes whose triangles have
    become hybrid or full move too; all others stay.

    Args:
        fabric: cloth, yarns and materials.
        change: both regions.
        loads: gravity, attachments, bodies and contact.
        old_terms: the terms of the old region, with their memory.
        positions: positions in the new region [cm]; changed.
        time_step: length of the step [s].
    """
    old, new = change.old, change.new
    same = np.flatnonzero(old.node_kind == new.node_kind)
    nodes = np.unique(np.concatenate([same, *(each.nodes for each in loads.held)]))
    known = np.flatnonzero(old.unknown_vertices)
    corners = np.unique(np.concatenate([known, *(each.vertices for each in loads.held)]))
    if np.isin(new.nodes, nodes).all() and np.isin(np.flatnonzero(new.unknown_vertices), corners).all():
        return
    stays = Attachment(corners, nodes)
    held = replace(loads, held=[stays], gravity=(0.0, 0.0, 0.0))
    system = loaded_system(fabric, change.new, held, scalar=positions.scalar, device=positions.device)
    carry_terms(old_terms, system.terms, change)
    # three iterations bring new nodes near to their equilibrium
    settings = EquilibriumSettings(most_iterations=3, first_time_step=time_step, longest_time_step=time_step)
    find_equilibrium(system, positions, settings)


def place_held(system: MixedSystem, motion: PrescribedMotion, positions: MixedVector, time: float) -> None:
    """Move attached nodes and vertices to their place at a time, and let the hybrid nodes and vertices follow.

    Args:
        system: the system.
        motion: the motion of the attachments.
        positions: positions [cm]; changed.
        time: the time [s].
    """
    present, places = positions.numpy(), motion.places(time)
    moves = [np.zeros_like(part) for part in present]
    for part, fixed in ((0, motion.fixed_vertices), (1, motion.fixed_nodes)):
        moves[part][fixed] = places[part][fixed] - present[part][fixed]
    vertices, nodes, sliding = moves
    wanted = MixedVector.from_numpy(vertices, nodes, sliding, system.scalar, system.device)
    choose(wanted, system.moves, wanted.like(), wanted)
    system.make_motion(wanted)
    set_sum(positions, 1.0, positions, 1.0, wanted)


Numbers = NDArray[np.float64]
Moving = tuple[MixedSystem, MixedVector, MixedVector]
"""A system, its positions [cm] and its velocities [cm/s]."""


def keep_momentum(before: Moving, after: Moving) -> None:
    """Change the velocities of a system so that it keeps the momentum that the cloth had before a change.

    Args:
        before: the system before the change.
        after: the system after it; its velocities are changed.
    """
    centre = before[1].numpy()[0].mean(axis=0)
    for system, positions, _velocities in (before, after):
        system.update_masses(positions)
    give_momentum(*after, centre, momentum_about(*before, centre))


def momentum_about(
    system: MixedSystem, positions: MixedVector, velocities: MixedVector, centre: NDArray[np.float64]
) -> Numbers:
    """Linear momentum [g cm/s] and angular momentum about a centre [g cm^2/s], shape (6,).

    Args:
        system: the system, with its masses at the positions of the last ``update_masses``.
        positions: positions [cm].
        velocities: velocities [cm/s].
        centre: the centre [cm], shape (3,).
    """
    product = system.zeros()
    system.set_mass_product(velocities, product)
    amount = np.concatenate(product.numpy()[:2])
    arm = np.concatenate(positions.numpy()[:2]) - centre
    return np.concatenate([amount.sum(axis=0), np.cross(arm, amount).sum(axis=0)])


def give_momentum(
    system: MixedSystem,
    positions: MixedVector,
    velocities: MixedVector,
    centre: NDArray[np.float64],
    expected: Numbers,
) -> None:
    """Add the rigid motion with which the velocities have the expected momentum.

    Args:
        system: the system.
        positions: positions [cm].
        velocities: velocities [cm/s]; changed.
        centre: centre of the angular momentum [cm], shape (3,).
        expected: linear and angular momentum, shape (6,), as ``momentum_about`` returns them.
    """
    rigid = [_rigid_motion(system, positions, centre, number) for number in range(6)]
    matrix = np.stack([momentum_about(system, positions, each, centre) for each in rigid], axis=1)
    missing = expected - momentum_about(system, positions, velocities, centre)
    amount = np.linalg.lstsq(matrix, missing, rcond=None)[0]
    for part, motion in zip(amount.tolist(), rigid, strict=True):
        set_sum(velocities, 1.0, velocities, part, motion)


def _rigid_motion(system: MixedSystem, positions: MixedVector, centre: Numbers, number: int) -> MixedVector:
    """Translation along an axis (0 to 2), or rotation about it (3 to 5), of the free coordinates."""
    axis = np.eye(3)[number % 3]
    places = positions.numpy()[:2]
    v, p = (np.tile(axis, (len(part), 1)) if number < 3 else np.cross(axis, part - centre) for part in places)
    motion = MixedVector.from_numpy(v, p, np.zeros((len(p), 2)), system.scalar, system.device)
    choose(motion, system.moves, motion, motion.like())
    system.make_motion(motion)
    return motion
