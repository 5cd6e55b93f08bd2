# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A fabric and what acts on it: the mixed system with attachments, bodies and contact.

``dynamics.cloth_system`` makes the system of cloth and yarns; contact is added here. Contact points lie on triangles,
with the weight 1 - alpha, and at yarn nodes, with the weight alpha, so that all of the cloth counts once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.contact.attachments import Attachment, at_simulated_nodes
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
from stitchmesh.mixed.contact.motion import RigidMotion
from stitchmesh.mixed.contact.self_collision import PRESSURE, SelfCollision
from stitchmesh.mixed.crossings.crossing_material import FabricMaterials
from stitchmesh.mixed.dynamics.cloth_system import ClothModel, cloth_system
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.layout.spline_yarns import LaidYarns, SplineYarns
from stitchmesh.mixed.splines.spline_material import SplineMaterial
from stitchmesh.mixed.term import EARTH, MixedTerm
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.seam_rod import SeamMaterial


@dataclass(frozen=True, eq=False, kw_only=True)
class MixedFabric:
    """A cloth with yarns laid out on it, and the materials of both."""

    cloth: Cloth
    """The triangles."""
    yarns: LaidYarns
    """The yarns, everywhere on the cloth."""
    cloth_material: ClothMaterial
    """Material of the triangles."""
    yarn_materials: FabricMaterials | SplineMaterial
    """Materials of the yarns; their kind belongs to the model of the yarns."""
    seam_material: SeamMaterial | None = None
    """Material of the rods along seams where triangles are simulated; None for none."""

    def __post_init__(self) -> None:
        if isinstance(self.yarns, SplineYarns) != isinstance(self.yarn_materials, SplineMaterial):
            found = f"{type(self.yarns).__name__} with {type(self.yarn_materials).__name__}"
            raise ParameterError(f"fabric: got {found}; expected yarns and a material of the same model")

    @property
    def yarn_radius(self) -> FloatArray:
        """Radius of each yarn [cm], shape (Y,)."""
        if isinstance(self.yarns, SplineYarns):
            return self.yarns.curves.radius
        assert isinstance(self.yarn_materials, FabricMaterials)
        return np.array([material.radius for material in self.yarn_materials.by_family])[self.yarns.yarn_family]


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
    model = ClothModel(fabric.cloth_material, fabric.yarn_materials, fabric.seam_material, acceleration=loads.gravity)
    made = cloth_system(
        fabric.cloth, fabric.yarns, region, model,
        fixed_vertices=np.concatenate([none, *(each.vertices for each in loads.held)]),
        fixed_nodes=np.concatenate([none, *(each.nodes for each in loads.held)]),
        vertices=vertices, scalar=scalar, device=device,
    )  # fmt: skip
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
        cloth.triangles, cloth.rest, cloth.panel, vertex_count=len(cloth.vertices), node_count=len(simulated),
        weight=1.0 - region.triangle_alpha, thickness=thickness,
    )  # fmt: skip
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
