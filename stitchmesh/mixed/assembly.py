# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What acts on a fabric: the mixed system with attachments, bodies and contact.

``dynamics.cloth_system`` makes the system of cloth and yarns; contact is added here. Contact points lie on triangles,
with the weight 1 - alpha, and at yarn nodes, with the weight alpha, so that all of the cloth counts once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.mixed.contact.body import SolidBody
from stitchmesh.mixed.contact.body_distance import BodyContact
from stitchmesh.mixed.contact.body_friction import BodyFriction
from stitchmesh.mixed.contact.contact_points import (
    ContactPoints,
    SeamLinks,
    join_points,
    points_at_nodes,
    points_on_triangles,
)
from stitchmesh.mixed.contact.layer_friction import LayerFriction
from stitchmesh.mixed.contact.motion import Attachment, RigidMotion, at_simulated_nodes
from stitchmesh.mixed.contact.self_collision import PRESSURE, SelfCollision
from stitchmesh.mixed.dynamics.cloth_system import MixedFabric, cloth_system
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.layout.spline_yarns import SplineYarns
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.simulation.dead_load import EARTH


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadedBody:
    """A body with the numbers of its contact."""

    body: SolidBody
    friction: float = 0.0
    """Coefficient of friction."""
    thickness: float = 0.0
    """Thickness of a layer on the body [cm]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Loads:
    """What acts on a fabric."""

    gravity: tuple[float, float, float] = EARTH
    """Acceleration [cm/s^2]."""
    held: Sequence[Attachment] = ()
    """Vertices and nodes of the layout that are held or moved."""
    bodies: Sequence[LoadedBody] = ()
    """Bodies."""
    self_collision: bool = False
    """Whether the cloth collides with itself."""
    thickness: float = 0.1
    """Thickness of the cloth in contact [cm]."""
    pressure: float = PRESSURE
    """Scale of the pressure of contact [dyn/cm^2]."""
    friction: float = 0.0
    """Coefficient of friction between layers of a cloth that collides with itself."""


def loaded_system(
    fabric: MixedFabric, region: Region, loads: Loads, vertices: FloatArray, *, scalar: Any, device: wp.Device
) -> MixedSystem:
    """Return the system of a fabric with yarns in a region, with everything that acts on it.

    Args:
        fabric: cloth, yarns and materials.
        region: where yarns are simulated.
        loads: gravity, attachments, bodies and contact.
        vertices: positions of the vertices at the start [cm], shape (V, 3).
        scalar: Warp's floating-point type.
        device: where the terms run.

    Raises:
        ParameterError: an attachment holds what does not exist, or a load is not possible.
    """
    none = np.zeros(0, dtype=np.int64)
    made = cloth_system(
        fabric,
        region,
        fixed_vertices=np.concatenate([none, *(each.vertices for each in loads.held)]),
        fixed_nodes=np.concatenate([none, *(each.nodes for each in loads.held)]),
        vertices=vertices,
        acceleration=loads.gravity,
        scalar=scalar,
        device=device,
    )
    for term in _contact_terms(fabric, region, loads, scalar, device):
        made.system.add(term)
    return made.system


def held_in_state(region: Region, held: Sequence[Attachment]) -> list[Attachment]:
    """Return attachments with the numbers that simulated nodes have in a state."""
    return at_simulated_nodes(held, region.node_number)


def _contact_terms(
    fabric: MixedFabric, region: Region, loads: Loads, scalar: Any, device: wp.Device
) -> list[MixedTerm]:
    if not loads.bodies and not loads.self_collision:
        return []
    points, links = contact_points(fabric, region, loads.thickness)
    if not len(points):
        return []
    terms: list[MixedTerm] = []
    for each in loads.bodies:
        contact = BodyContact(
            points, each.body, thickness=each.thickness, pressure=loads.pressure, scalar=scalar, device=device
        )
        terms += [contact, BodyFriction(contact, each.friction)] if each.friction else [contact]
    if loads.self_collision:
        layers = SelfCollision(points, links, pressure=loads.pressure, scalar=scalar, device=device)
        terms += [layers, LayerFriction(layers, loads.friction)] if loads.friction else [layers]
    return terms


def contact_points(fabric: MixedFabric, region: Region, thickness: float) -> tuple[ContactPoints, SeamLinks]:
    """Return contact points on triangles and at nodes, weighted by alpha, and the links of seams."""
    cloth, yarns, simulated = fabric.cloth, fabric.yarns, region.nodes
    # ``of_node``: control points of B-splines lie in the middle of a yarn, crossing nodes in the middle of the cloth
    of_node = 2.0 * float(fabric.yarn_radius.mean()) if isinstance(yarns, SplineYarns) else thickness
    on_triangles, links = points_on_triangles(
        cloth, node_count=len(simulated), weight=1.0 - region.triangle_alpha, thickness=thickness
    )
    at_nodes = points_at_nodes(
        len(cloth.vertices), panel=yarns.panel[simulated], rest=yarns.position[simulated],
        area=float(cloth.rest_area.sum()) / yarns.node_count, weight=region.node_alpha[simulated], thickness=of_node,
    )  # fmt: skip
    return join_points([on_triangles, at_nodes]), links


def bodies_at(bodies: Sequence[LoadedBody], time: float) -> list[Mesh]:
    """Return the surfaces of bodies at a time [s]."""
    moved = []
    for each in bodies:
        mesh, motion = each.body.mesh, each.body.motion
        if isinstance(motion, RigidMotion):
            place = motion.places_at(mesh.vertices, time)
        else:
            place = motion.vertices_at(time)
        moved.append(Mesh(place, mesh.face_start, mesh.face_vertex, mesh.twin))
    return moved
