# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Takes the state of a run over into another region.

Positions and velocities move as in ``placement.moved_state``, and the memory of terms as in
``placement.carried_terms``. Attached nodes and vertices go to the place that their attachment prescribes, and the
hybrid nodes and vertices around them follow: attached nodes that begin on a triangle with a free corner are not at this
place.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.assembly import Loads, contact_points, loaded_system
from stitchmesh.mixed.contact.attachments import Attachment, PrescribedMotion
from stitchmesh.mixed.dynamics.cloth_system import MixedFabric
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
    vertices: FloatArray,
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
        vertices: positions of the vertices at the start of the run [cm], shape (V, 3).
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
    system = loaded_system(fabric, change.new, held, vertices, scalar=positions.scalar, device=positions.device)
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
