# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mixed system of a cloth with yarns in a region of interest, and of everything that acts on it.

``loaded_system`` makes it: the energies of the yarns, of the triangles and of the rods along seams, the weight, and the
contact with bodies and of the cloth with itself. All energies of the triangles have the weight 1 - alpha, all energies
of the yarns the weight alpha, and masses are blended (Casafranca et al. 2020, sections 4.1 and 4.2). Contact points lie
on triangles, with the weight 1 - alpha, and at yarn nodes, with the weight alpha, so that all of the cloth counts once.

The two yarn models, crossings and B-splines, differ in the contents of ``YarnPart``. The masses of the triangles, and
of the rods along seams, are computed here; ``dynamics.mass_matrix`` lumps them at vertices.

``start_positions`` places the nodes. Where nodes of B-splines stand out of the triangles, their places do not have the
form p = B v + F x. ``enrichment.projection`` changes them to this form; the heights of the loops then belong to F x.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.precision import ScalarType
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mixed.cloth.cloth import Cloth
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
from stitchmesh.mixed.contact.motion import Attachment, RigidMotion
from stitchmesh.mixed.contact.self_collision import PRESSURE, SelfCollision
from stitchmesh.mixed.crossings.crossing_material import FabricMaterials
from stitchmesh.mixed.crossings.crossing_term import CrossingTerm, crossing_elements
from stitchmesh.mixed.crossings.friction.sliding_friction import SlidingFriction
from stitchmesh.mixed.crossings.stitch_term import StitchTerm, stitch_elements
from stitchmesh.mixed.crossings.yarn_mass import YarnGravity, YarnMass
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses, FabricPoints, NodeMasses, blend_masses
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.spline_part import spline_masses, spline_term
from stitchmesh.mixed.enrichment.balanced_weights import StretchedCloth, StretchWeights, balanced_weights
from stitchmesh.mixed.enrichment.projection import make_consistent
from stitchmesh.mixed.enrichment.region import TRIANGLES, FreeUnknowns, Region, embed
from stitchmesh.mixed.layout.crossing_yarns import WARP, WEFT, CrossingYarns
from stitchmesh.mixed.layout.spline_yarns import LaidYarns, SplineYarns
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.splines.spline_pieces import SplineMaterial
from stitchmesh.mixed.term import FULL, MixedTerm
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial, checked_weights
from stitchmesh.mixed.triangles.membrane import Membrane
from stitchmesh.mixed.triangles.seam_rod import SeamMaterial, SeamRod, rest_lengths
from stitchmesh.mixed.triangles.shell_bending import ShellBending
from stitchmesh.simulation.dead_load import EARTH, Gravity
from stitchmesh.simulation.term import LoadedPoints, TermChoice


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
    terms: Sequence[TermChoice[LoadedPoints]] = ()
    """Further loads, such as ``Wind``."""


@dataclass(frozen=True, eq=False)
class YarnPart:
    """The part of the system that depends on the yarn model."""

    terms: Sequence[MixedTerm]
    """Energies of the yarns."""
    slides: NDArray[np.bool_]
    """Whether the model lets each Eulerian coordinate move, shape (n, 2)."""
    node_masses: NodeMasses | None
    """Blocks of the mass matrix at the nodes; the masses alone by default."""
    weighs: bool
    """Whether the terms include the weight of the yarns."""


def loaded_system(
    fabric: MixedFabric,
    region: Region,
    loads: Loads,
    *,
    scalar: ScalarType = wp.float64,
    device: wp.Device,
    always_held: Sequence[Attachment] | None = None,
) -> MixedSystem:
    """Return the system of a fabric with yarns in a region, with everything that acts on it.

    Args:
        fabric: cloth, yarns and materials.
        region: where yarns are simulated, made from the triangles and the nodes of the layout.
        loads: gravity, attachments, bodies and contact.
        scalar: Warp's floating-point type.
        device: where the terms run.
        always_held: attachments that hold more than the result of this system, by which the base motion of hybrid nodes
            is chosen (``embed``); by default the attachments of the loads.

    Raises:
        ParameterError: an attachment holds what does not exist, masses do not fit, or a load is not possible.
    """
    stretch = _stretch_weights(fabric.cloth, fabric.yarns, region)
    of_yarns = _yarn_part(fabric, region, stretch, loads.gravity, scalar, device)
    masses = fabric_masses(fabric, region)
    without_weight = np.zeros_like(masses.yarns) if of_yarns.weighs else masses.yarns
    terms = [
        *of_yarns.terms,
        *_triangle_terms(fabric, region, stretch, scalar, device),
        *_dead_loads(fabric, masses, without_weight, loads, scalar, device),
        *_contact_terms(fabric, region, loads, scalar, device),
    ]
    fixed_vertices, fixed_nodes = fixed_points(loads.held)
    free = FreeUnknowns.of(region, fixed_vertices=fixed_vertices, fixed_nodes=fixed_nodes)
    free = replace(free, sliding=free.sliding & of_yarns.slides)
    return MixedSystem(
        embed(region, *fixed_points(loads.held if always_held is None else always_held)), free, masses, terms,
        node_masses=of_yarns.node_masses, scalar=scalar, device=device,
    )  # fmt: skip


def fixed_points(held: Sequence[Attachment]) -> tuple[IntArray, IntArray]:
    """Return the vertices and the nodes that attachments hold."""
    none = np.zeros(0, dtype=np.int64)
    vertices = np.concatenate([none, *(each.vertices for each in held)])
    return vertices, np.concatenate([none, *(each.nodes for each in held)])


def _dead_loads(
    fabric: MixedFabric, masses: BlendedMasses, weighing: NDArray[np.float64], loads: Loads, scalar: ScalarType,
    device: wp.Device,
) -> list[MixedTerm]:  # fmt: skip
    """Return gravity, with the masses ``weighing`` at the nodes, and the further loads."""
    area = float(fabric.cloth.rest_area.sum())
    weighed = FabricPoints(BlendedMasses(masses.vertices, weighing), area, scalar, device)
    points = FabricPoints(masses, area, scalar, device)
    return [Gravity(loads.gravity).on(weighed), *(choice.on(points) for choice in loads.terms)]


def start_positions(
    fabric: MixedFabric, region: Region, system: MixedSystem, vertices: FloatArray | None = None
) -> MixedVector:
    """Return the positions at the beginning: nodes lie on their triangles, or above them, and yarns are as laid out.

    Args:
        fabric: cloth and yarns.
        region: where yarns are simulated.
        system: the system of the fabric with this region.
        vertices: positions of the vertices [cm], shape (V, 3); by default the positions of the cloth.
    """
    corners = fabric.cloth.vertices if vertices is None else vertices
    nodes = fabric.yarns.world(fabric.cloth, corners)[region.nodes]
    sliding = fabric.yarns.rest_sliding[region.nodes]
    positions = MixedVector.from_numpy(corners, nodes, sliding, system.scalar, system.device)
    make_consistent(system.embedding, system.free, positions)
    return positions


def _yarn_part(
    fabric: MixedFabric,
    region: Region,
    stretch: StretchWeights | None,
    acceleration: tuple[float, float, float],
    scalar: ScalarType,
    device: wp.Device,
) -> YarnPart:
    """Energies, sliding and inertia of the yarns."""
    yarns, material = fabric.yarns, fabric.yarn_materials
    if isinstance(yarns, SplineYarns):
        assert isinstance(material, SplineMaterial)
        term = spline_term(fabric.cloth, yarns, material, region, scalar, device)
        still = np.zeros((len(region.nodes), 2), dtype=bool)
        return YarnPart([] if term is None else [term], still, None, weighs=False)
    assert isinstance(material, FabricMaterials)
    nodes, alpha = region.nodes, region.node_alpha[region.nodes]
    elements = crossing_elements(yarns, material, nodes=nodes, alpha=alpha, full=alpha >= FULL)
    if stretch is not None:
        elements = replace(elements, stretch=elements.stretch * _segment_shares(yarns, region, stretch)[nodes])
    terms: list[MixedTerm] = []
    if elements.count:
        elastic = CrossingTerm(elements, scalar, device)
        terms = [elastic, YarnGravity(elements, scalar, device, acceleration)]
        if yarns.kind == "knit":
            stitches = stitch_elements(yarns, elements, material.weft, alpha=alpha, full=alpha >= FULL)
            terms += [StitchTerm(stitches, elements.count, scalar, device)] if len(stitches.nodes) else []
        terms.append(SlidingFriction(elements, elastic))
    return YarnPart(terms, elements.slides, YarnMass(elements, scalar, device), weighs=True)


def triangle_masses(cloth: Cloth, material: ClothMaterial) -> NDArray[np.float64]:
    """Mass of each triangle: area at rest times density [g], shape (T,)."""
    masses: NDArray[np.float64] = cloth.rest_area * material.density
    return masses


def rod_masses(cloth: Cloth, material: SeamMaterial, weight: ArrayLike | None = None) -> NDArray[np.float64]:
    """Lumped mass of each vertex from the rods along the seams, half of each edge at its ends [g], shape (V,).

    Args:
        cloth: a cloth with S edges on seams.
        material: density of the rods.
        weight: blending weight of each edge, shape (S,); by default 1.

    Raises:
        ParameterError: a weight is not in [0, 1].
    """
    mass = rest_lengths(cloth) * material.density * checked_weights(weight, len(cloth.seam_edges))
    lumped = np.bincount(cloth.seam_edges.ravel(), np.repeat(mass / 2.0, 2), len(cloth.vertices))
    return lumped.astype(np.float64)


def fabric_masses(fabric: MixedFabric, region: Region) -> BlendedMasses:
    """Masses of a fabric: from its yarns in the enriched region, and from the density of the cloth elsewhere."""
    cloth, yarns, material = fabric.cloth, fabric.yarns, fabric.yarn_materials
    of_triangles = triangle_masses(cloth, fabric.cloth_material)
    if isinstance(yarns, SplineYarns):
        assert isinstance(material, SplineMaterial)
        blended = spline_masses(yarns.curves, material.density, region, of_triangles)
    else:
        assert isinstance(material, FabricMaterials)
        blended = _crossing_masses(yarns, material, region, of_triangles)
    if fabric.seam_material is None:
        return blended
    # in the hybrid region the mass of the triangles comes from the yarns, and includes their rods
    outside = (region.triangle_kind[cloth.seam_sides // 3] == TRIANGLES).mean(axis=1)
    of_rods = rod_masses(cloth, fabric.seam_material, outside)
    return BlendedMasses(blended.vertices + of_rods, blended.yarns)


def _crossing_masses(
    yarns: CrossingYarns, materials: FabricMaterials, region: Region, of_triangles: NDArray[np.float64]
) -> BlendedMasses:
    """Blended masses of a cloth with the yarn between its crossings."""
    ends, coordinates = _segments(yarns)
    begin, end = yarns.rest_sliding[ends, coordinates].T
    density = np.array([material.density for material in materials.by_family])
    mass = (end - begin) * density[yarns.yarn_family[yarns.node_yarn[ends[:, 0], coordinates[:, 0]]]]
    return blend_masses(region, ends, mass, coordinates, of_triangles)


def _stretch_weights(cloth: Cloth, yarns: LaidYarns, region: Region) -> StretchWeights | None:
    """Weights of stretch with which uniform tension of a weave balances; None for yarns that turn, as in a knit."""
    if isinstance(yarns, SplineYarns) or yarns.kind != "weave":
        return None
    ends, coordinates = _segments(yarns)
    begin, end = yarns.rest_sliding[ends, coordinates].T
    family = yarns.yarn_family[yarns.node_yarn[ends[:, 0], coordinates[:, 0]]]
    # segments of wefts are as long as the distance of the warps
    apart = np.array([_median((end - begin)[family == other]) for other in (WARP, WEFT)])
    edges = np.linalg.inv(np.swapaxes(cloth.rest[:, 1:] - cloth.rest[:, :1], 1, 2))
    gradients = np.concatenate([-edges.sum(axis=1, keepdims=True), edges], axis=1)
    border = np.zeros(len(cloth.vertices), dtype=bool)
    border[cloth.side_vertices[cloth.border_sides]] = True
    return balanced_weights(region, StretchedCloth(gradients, cloth.rest_area, border, ends, family, apart))


def _median(lengths: NDArray[np.float64]) -> float:
    """The median, or zero without yarns."""
    return float(np.median(lengths)) if len(lengths) else 0.0


def _segment_shares(yarns: CrossingYarns, region: Region, stretch: StretchWeights) -> NDArray[np.float64]:
    """Weight of the stretch of the segment after each node, divided by its alpha, shape (N, 2)."""
    ends, coordinates = _segments(yarns)
    alpha, shares = region.element_alpha(ends), np.ones((yarns.node_count, 2))
    there = alpha > 0.0
    shares[ends[there, 0], coordinates[there, 0]] = stretch.segments[there] / alpha[there]
    return shares


def _segments(yarns: CrossingYarns) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Both nodes of each segment of yarn, and their coordinates along this yarn (0 for u, 1 for v), shapes (E, 2)."""
    node, coordinate = np.nonzero(yarns.links[:, 0::2] >= 0)
    after = yarns.links[node, 2 * coordinate]
    return np.stack([node, after // 2], axis=1), np.stack([coordinate, after % 2], axis=1)


def _edge_weights(cloth: Cloth, region: Region) -> NDArray[np.float64]:
    """Weight 1 - alpha of each edge of a seam, shape (S,); zero among yarns alone, where a vertex is not unknown.

    The rods of the yarns have the weight alpha, so each rod counts once along its whole length.
    """
    edges = cloth.seam_edges
    among_yarns = ~region.unknown_vertices[edges].all(axis=1)
    return np.where(among_yarns, 0.0, 1.0 - region.vertex_alpha[edges].mean(axis=1))


def _triangle_terms(
    fabric: MixedFabric, region: Region, stretch: StretchWeights | None, scalar: ScalarType, device: wp.Device
) -> list[MixedTerm]:
    """The energies of the triangles and of the rods along seams."""
    cloth, material = fabric.cloth, fabric.cloth_material
    weight = 1.0 - region.triangle_alpha
    shares = None if stretch is None else stretch.triangles / np.where(weight > 0.0, weight, 1.0)[:, None]
    terms: list[MixedTerm] = [Membrane(cloth, material, scalar, device, weight, shares)]
    if len(cloth.hinges):
        terms.append(ShellBending(cloth, material, scalar, device, weight))
    if fabric.seam_material is not None and len(cloth.seam_edges):
        terms.append(SeamRod(cloth, fabric.seam_material, scalar, device, _edge_weights(cloth, region)))
    return terms


def _contact_terms(
    fabric: MixedFabric, region: Region, loads: Loads, scalar: ScalarType, device: wp.Device
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
