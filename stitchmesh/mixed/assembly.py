# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mixed system of a fabric: from cloth, yarns, materials and a region to unknowns, masses and terms.

Nodes are numbered as in the layout, which covers the whole cloth, or as the nodes that are simulated. Yarn elements
exist where all their nodes are simulated, with the mean of alpha at their nodes as weight; triangles have the weight
1 - alpha (Casafranca et al. 2020, sections 4.1 and 4.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.contact.attachments import Attachment, at_simulated_nodes
from stitchmesh.mixed.contact.body import Body
from stitchmesh.mixed.contact.body_distance import BodyContact
from stitchmesh.mixed.contact.body_friction import BodyFriction
from stitchmesh.mixed.contact.contact_points import ContactPoints, join_points, points_at_nodes
from stitchmesh.mixed.contact.self_collision import PRESSURE, SelfCollision
from stitchmesh.mixed.contact.triangle_points import SeamLinks, points_on_triangles
from stitchmesh.mixed.crossings.crossing_elements import CrossingElements, crossing_elements
from stitchmesh.mixed.crossings.crossing_term import CrossingTerm
from stitchmesh.mixed.crossings.fabric_materials import FabricMaterials
from stitchmesh.mixed.crossings.sliding_friction import SlidingFriction
from stitchmesh.mixed.crossings.stitch_term import StitchTerm, stitch_elements
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
    yarn_materials: FabricMaterials
    """Materials of the yarns."""

    @property
    def yarn_radius(self) -> FloatArray:
        """Radius of each yarn [cm], shape (Y,)."""
        return np.array([material.radius for material in self.yarn_materials.by_family])[self.yarns.yarn_family]


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
    masses, elements = fabric_masses(fabric, region), yarn_elements(fabric, region)
    terms = [*_triangle_terms(fabric, region, scalar, device), *_yarn_terms(fabric, region, elements, scalar, device)]
    terms += _contact_terms(fabric, region, loads, scalar, device)
    system = MixedSystem(
        embed(region), free_unknowns(region, loads.held, elements), masses, terms,
        node_masses=YarnMass(elements, scalar, device) if elements.count else None, scalar=scalar, device=device,
    )  # fmt: skip
    if any(loads.gravity):
        system.add(Weight(system.mass, loads.gravity))
    return system


def free_unknowns(region: Region, held: Sequence[Attachment], elements: CrossingElements) -> FreeUnknowns:
    """Return what is unknown beside what attachments hold, and beside the ends of yarns, which do not slide."""
    vertices = [each.vertices for each in held if each.stiffness is None]
    nodes = [each.nodes for each in held if each.stiffness is None]
    none = np.zeros(0, dtype=np.int64)
    free = FreeUnknowns.of(
        region, fixed_vertices=np.concatenate([none, *vertices]), fixed_nodes=np.concatenate([none, *nodes])
    )
    return replace(free, sliding=free.sliding & elements.slides)


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
    density = np.array([material.density for material in fabric.yarn_materials.by_family])
    mass = density[yarns.yarn_family[yarns.passage_yarn[first]]] * length
    return blend_masses(region, ends, mass, coordinate, triangle_masses(fabric.cloth, fabric.cloth_material))


def yarn_elements(fabric: MixedFabric, region: Region) -> CrossingElements:
    """Return the elements of the simulated nodes."""
    return crossing_elements(
        fabric.yarns, fabric.yarn_materials, nodes=region.nodes, alpha=_alpha_at_nodes(region)[region.nodes]
    )


def _alpha_at_nodes(region: Region) -> NDArray[np.float64]:
    """Alpha at the nodes of the layout, not zero at those that are simulated, exactly 1 in the full-yarn region."""
    return np.where(region.node_kind == YARNS, 1.0, np.maximum(region.node_alpha, region.smallest_alpha))


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
    crossing = CrossingTerm(elements, scalar, device)
    terms: list[Term] = [crossing, SlidingFriction(elements, crossing)]
    if fabric.yarns.kind == "knit":
        alpha = _alpha_at_nodes(region)[region.nodes]
        stitches = stitch_elements(fabric.yarns, elements, fabric.yarn_materials.weft, alpha=alpha)
        terms.append(StitchTerm(stitches, elements.count, scalar, device))
    return terms


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
