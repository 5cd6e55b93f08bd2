# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mixed system of a fabric: from cloth, yarns, materials and a region to unknowns, masses and terms.

Numbers of nodes change from those of the layout, which covers the whole cloth, to those of the nodes that are simulated.
Yarn elements exist where all their nodes are simulated, with the mean of alpha at their nodes as weight; triangles have
the weight 1 - alpha (Casafranca et al. 2020, sections 4.1 and 4.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.contact.attachments import Attachment, at_simulated_nodes
from stitchmesh.mixed.contact.body import Body
from stitchmesh.mixed.contact.body_distance import BodyContact
from stitchmesh.mixed.contact.body_friction import BodyFriction
from stitchmesh.mixed.contact.contact_points import ContactPoints, join_points, points_at_nodes
from stitchmesh.mixed.contact.self_collision import PRESSURE, SelfCollision
from stitchmesh.mixed.contact.triangle_points import SeamLinks, points_on_triangles
from stitchmesh.mixed.crossings.crossing_elements import CrossingElements, crossing_elements
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.crossing_term import CrossingTerm
from stitchmesh.mixed.crossings.sliding_friction import SlidingFriction
from stitchmesh.mixed.crossings.yarn_mass import YarnMass
from stitchmesh.mixed.dynamics.blended_masses import BlendedMasses, blend_masses
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.weight import Weight
from stitchmesh.mixed.enrichment.embedding import embed
from stitchmesh.mixed.enrichment.free_unknowns import FreeUnknowns
from stitchmesh.mixed.enrichment.region import YARNS, Region
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.term import Term
from stitchmesh.mixed.triangles.cloth_mass import triangle_masses
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.membrane import Membrane
from stitchmesh.mixed.triangles.shell_bending import ShellBending


@dataclass(frozen=True, eq=False, kw_only=True)
class MixedFabric:
    """A cloth with yarns laid out on it, and the materials of both."""

    cloth: Cloth
    """The triangles."""
    yarns: CrossingYarns
    """The yarns, everywhere on the cloth."""
    cloth_material: ClothMaterial
    """Material of the triangles."""
    yarn_materials: tuple[CrossingMaterial, CrossingMaterial]
    """Materials of the u yarns (wefts, courses) and of the v yarns (warps)."""

    @property
    def yarn_radius(self) -> FloatArray:
        """Radius of each yarn [cm], shape (Y,)."""
        radii = np.array([self.yarn_materials[0].radius, self.yarn_materials[1].radius])
        return radii[np.minimum(self.yarns.yarn_family, 1)]


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadedBody:
    """A body with the numbers of its contact."""

    body: Body
    friction: float = 0.0
    """Coefficient of friction."""
    thickness: float = 0.0
    """Thickness of a layer on the body [cm]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Loads:
    """What acts on a fabric."""

    gravity: tuple[float, float, float] = (0.0, -981.0, 0.0)
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


def mixed_system(fabric: MixedFabric, region: Region, loads: Loads, *, scalar: Any, device: wp.Device) -> MixedSystem:
    """Return the system of a fabric with yarns in a region.

    Args:
        fabric: cloth, yarns and materials.
        region: where yarns are simulated.
        loads: gravity, attachments, bodies and contact.
        scalar: Warp's floating-point type.
        device: where the terms run.

    Raises:
        ParameterError: an attachment holds what does not exist, or a load is not possible.
    """
    masses = fabric_masses(fabric, region)
    elements = yarn_elements(fabric, region)
    terms = [*_triangle_terms(fabric, region, scalar, device), *_yarn_terms(fabric, region, elements, scalar, device)]
    terms += _contact_terms(fabric, region, loads, scalar, device)
    system = MixedSystem(
        embed(region), free_unknowns(region, loads.held), masses, terms,
        node_masses=YarnMass(elements, scalar, device) if elements.count else None, scalar=scalar, device=device,
    )  # fmt: skip
    if any(loads.gravity):
        system.add(Weight(system.mass, loads.gravity))
    return system


def free_unknowns(region: Region, held: Sequence[Attachment]) -> FreeUnknowns:
    """Return what is unknown beside what attachments hold."""
    vertices = [each.vertices for each in held if each.stiffness is None]
    nodes = [each.nodes for each in held if each.stiffness is None]
    none = np.zeros(0, dtype=np.int64)
    return FreeUnknowns.of(
        region, fixed_vertices=np.concatenate([none, *vertices]), fixed_nodes=np.concatenate([none, *nodes])
    )


def held_in_state(region: Region, held: Sequence[Attachment]) -> list[Attachment]:
    """Return attachments with the numbers that simulated nodes have in a state."""
    return at_simulated_nodes(held, region.node_number)


def fabric_masses(fabric: MixedFabric, region: Region) -> BlendedMasses:
    """Return the masses of vertices and simulated nodes."""
    yarns = fabric.yarns
    first = np.flatnonzero(yarns.passage_yarn[1:] == yarns.passage_yarn[:-1])
    ends = np.stack([yarns.yarn_node[first], yarns.yarn_node[first + 1]], axis=1)
    coordinate = np.stack([yarns.yarn_coordinate[first], yarns.yarn_coordinate[first + 1]], axis=1)
    length = np.diff(yarns.rest_sliding[ends, coordinate], axis=1)[:, 0]
    density = np.array([material.density for material in fabric.yarn_materials])[coordinate[:, 0]]
    return blend_masses(region, ends, density * length, coordinate, triangle_masses(fabric.cloth, fabric.cloth_material))


def yarn_elements(fabric: MixedFabric, region: Region) -> CrossingElements:
    """Return the elements of the simulated nodes, with the rest angles of the layout."""
    yarns, simulated = fabric.yarns, region.nodes
    links = _links_in_state(yarns.links[simulated], region.node_number)
    alpha = np.where(region.node_kind == YARNS, 1.0, np.maximum(region.node_alpha, region.smallest_alpha))
    elements = crossing_elements(
        links,
        yarns.rest_sliding[simulated],
        yarns.position[simulated],
        yarns.side[simulated],
        fabric.yarn_materials,
        weight=alpha[simulated],
        slides=region.sliding_nodes & ~yarns.on_rod[simulated],
        touches=~_within_contacts(yarns)[simulated],
        shears=yarns.kind == "weave",
    )
    turning = (links[:, 0::2] >= 0) & (links[:, 1::2] >= 0)
    return replace(elements, rest_turn=yarns.rest_turn[simulated] * turning, rest_shear=yarns.rest_shear[simulated].copy())


def _links_in_state(links: IntArray, node_number: IntArray) -> IntArray:
    """Links 2 j + c with the numbers of the simulated nodes; -1 where the neighbour is not simulated."""
    number = np.where(links >= 0, node_number[links // 2], -1)
    return np.where(number >= 0, 2 * number + links % 2, -1)


def _within_contacts(yarns: CrossingYarns) -> NDArray[np.bool_]:
    """Whether the segment after each node, along u and along v, lies within a stitch contact; shape (N, 2)."""
    partner = np.full(yarns.node_count, -2)
    partner[yarns.stitch_contacts] = yarns.stitch_contacts[:, ::-1]
    within: NDArray[np.bool_] = yarns.neighbours[:, 0::2] == partner[:, None]
    return within


def _triangle_terms(fabric: MixedFabric, region: Region, scalar: Any, device: wp.Device) -> list[Term]:
    weight = 1.0 - region.triangle_alpha
    if not weight.any():
        return []
    kinds = (Membrane, ShellBending)
    return [kind(fabric.cloth, fabric.cloth_material, scalar, device, weight) for kind in kinds]


def _yarn_terms(
    fabric: MixedFabric, region: Region, elements: CrossingElements, scalar: Any, device: wp.Device
) -> list[Term]:
    if not elements.count:
        return []
    yarns, simulated = fabric.yarns, region.nodes
    crossing = CrossingTerm(elements, scalar, device)
    friction = SlidingFriction(
        elements, crossing, yarns.rest_sliding[simulated], yarns.side[simulated], fabric.yarn_materials
    )
    return [crossing, friction]


def _contact_terms(fabric: MixedFabric, region: Region, loads: Loads, scalar: Any, device: wp.Device) -> list[Term]:
    if not loads.bodies and not loads.self_collision:
        return []
    points, links = contact_points(fabric, region, loads.thickness)
    terms: list[Term] = []
    for each in loads.bodies:
        contact = BodyContact(
            points, each.body, thickness=each.thickness, pressure=loads.pressure, scalar=scalar, device=device
        )
        terms += [contact, BodyFriction(contact, each.friction)] if each.friction else [contact]
    if loads.self_collision:
        terms.append(SelfCollision(points, links, pressure=loads.pressure, scalar=scalar, device=device))
    return terms


def contact_points(fabric: MixedFabric, region: Region, thickness: float) -> tuple[ContactPoints, SeamLinks]:
    """Return contact points on triangles and at nodes, weighted by alpha, and the links of seams."""
    cloth, yarns, simulated = fabric.cloth, fabric.yarns, region.nodes
    on_triangles, links = points_on_triangles(
        cloth.triangles, cloth.rest, cloth.panel, vertex_count=len(cloth.vertices), node_count=len(simulated),
        weight=1.0 - region.triangle_alpha, thickness=thickness,
    )  # fmt: skip
    at_nodes = points_at_nodes(
        len(cloth.vertices), panel=yarns.panel[simulated], rest=yarns.position[simulated],
        area=float(cloth.rest_area.sum()) / yarns.node_count, weight=region.node_alpha[simulated], thickness=thickness,
    )  # fmt: skip
    return join_points([on_triangles, at_nodes]), links
