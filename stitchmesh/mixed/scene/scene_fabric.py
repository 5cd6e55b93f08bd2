# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Makes the parts of a simulation from a scene: the fabric, its region, its loads and all positions at the start.

A scene that names no material of its cloth gets one that follows from its yarns. With e warps and p wefts per cm, and
for each family of yarns the stiffnesses of stretch k_s and of bending k_b, the shear stiffness k_x of a quadrant, and
the linear density rho (Cirio et al. 2014), this is for a weave:

    stretch p k_s, e k_s    [dyn/cm],     bending p k_b, e k_b    [dyn cm],     density p rho + e rho    [g/cm^2],
    shear 4 k_x L e p       [dyn/cm],     because each crossing has four quadrants, and L is the mean of their legs.

Crossings turn freely about the normal, so only the shear of quadrants resists twist; the twist rigidity is set to a
tenth of the geometric mean of both rigidities. Sliding, crimp and contact of yarns are left out: a material that is
fitted to the yarns (``matched_cloth``) agrees better. ``scene_splines`` makes the B-spline yarns of scenes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.compute.free_memory import host_memory
from stitchmesh.errors import ParameterError, described
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.assembly import LoadedBody, Loads, MixedFabric
from stitchmesh.mixed.cloth.cloth import Cloth, vertex_normals
from stitchmesh.mixed.contact.dressing import WornBody, dressed_vertices
from stitchmesh.mixed.contact.motion import Attachment
from stitchmesh.mixed.contact.self_collision import PRESSURE
from stitchmesh.mixed.crossings.crossing_material import DEFAULT, CrossingMaterial, FabricMaterials
from stitchmesh.mixed.enrichment.region import Region, region_around
from stitchmesh.mixed.layout.crossing_yarns import ROD
from stitchmesh.mixed.layout.from_stitches import lay_stitches
from stitchmesh.mixed.layout.spline_yarns import LaidYarns, SplineYarns
from stitchmesh.mixed.memory import check_layout_memory
from stitchmesh.mixed.scene.motion_section import AttachmentSection
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import MATCHED, STITCHES, Scene, YarnsSection
from stitchmesh.mixed.splines.spline_pieces import SplineMaterial
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.material_file import material_of, named_material
from stitchmesh.mixed.triangles.seam_rod import SeamMaterial
from stitchmesh.progress import Progress, no_progress
from stitchmesh.simulation.term import LoadedPoints, TermChoice


@dataclass(frozen=True, eq=False, kw_only=True)
class PreparedScene:
    """The parts of the simulation of a scene."""

    scene: Scene
    fabric: MixedFabric
    region: Region
    vertices: FloatArray
    """Positions of the vertices at the start [cm], shape (V, 3)."""
    held: tuple[Attachment, ...]
    """The attachments of the scene; nodes have their layout numbers."""
    bodies: tuple[LoadedBody, ...]
    terms: tuple[TermChoice[LoadedPoints], ...] = ()
    """Further loads, such as ``Wind``."""
    triangle_equilibrium: FloatArray | None = None
    """Vertices at an equilibrium of the triangles alone, where the yarns of a static run begin [cm], shape (V, 3)."""

    @property
    def without_yarns(self) -> Region:
        """The region of a run with triangles alone."""
        return RegionSection(yarns="none").region(self.fabric.cloth, self.fabric.yarns)

    @property
    def nodes(self) -> FloatArray:
        """Positions of the simulated nodes at the start [cm], shape (n, 3)."""
        return self.fabric.yarns.world(self.fabric.cloth, self.vertices)[self.region.nodes]

    @property
    def sliding(self) -> FloatArray:
        """Eulerian coordinates of the simulated nodes at the start [cm], shape (n, 2)."""
        return self.fabric.yarns.rest_sliding[self.region.nodes]

    def loads(self, time: float) -> Loads:
        """Return the loads at a time [s]; attachments are held until they are released."""
        sections = zip(self.scene.attachments, self.held, strict=True)
        contact = self.scene.contact
        radius = float(self.fabric.yarn_radius.max())
        return Loads(
            gravity=self.scene.gravity,
            held=[held for section, held in sections if section.release is None or time < section.release],
            bodies=self.bodies,
            self_collision=contact.self_collision,
            thickness=contact.thickness or 4.0 * radius,
            pressure=contact.pressure or PRESSURE,
            friction=contact.friction,
            terms=self.terms,
        )

    @property
    def releases(self) -> list[float]:
        """Times at which attachments are released [s], ascending."""
        return sorted({one.release for one in self.scene.attachments if one.release is not None})


def prepare(
    scene: Scene, *, cloth: Cloth | None = None, yarns: LaidYarns | None = None,
    terms: Sequence[TermChoice[LoadedPoints]] = (), folder: Path | None = None, progress: Progress = no_progress,
) -> PreparedScene:  # fmt: skip
    """Make the parts of the simulation of a scene.

    Args:
        scene: the scene.
        cloth: a cloth that replaces the cloth of the scene.
        yarns: yarns laid out on this cloth, which replace the yarns of the scene.
        terms: further loads.
        folder: where a material that is matched to the yarns is kept and found again.
        progress: called with the completed part of the matching and a line of text.

    Raises:
        ParameterError: a name is unknown, a box holds nothing, or a setting is not possible.
        FileError: a file cannot be read.
        MeshError: the panels or a body do not form a surface as expected.
    """
    for term in terms:
        if not isinstance(term, TermChoice) or not term.on_any_points:
            expected = "expected loads that act on cloth too, such as Wind((0, 0, 400))"
            raise ParameterError(f"drape, terms: got {described(term)}; {expected}")
    surface = scene.cloth.cloth() if cloth is None else cloth
    laid = _layout(scene, surface) if yarns is None else yarns
    materials = _materials(scene.yarns, laid)
    region = scene.region.region(surface, laid)
    held, bodies = _held(scene, surface, laid), _bodies(scene)
    check_simulated(held, region)
    material = _cloth_material(scene, surface, laid, materials, folder, progress)  # last: a match takes seconds
    fabric = MixedFabric(
        cloth=surface,
        yarns=laid,
        cloth_material=material,
        yarn_materials=materials,
        seam_material=_seam_material(laid, materials) if scene.cloth.seam_rods else None,
    )
    start = _disturbed(surface, scene.disturbance)
    prepared = PreparedScene(
        scene=scene, fabric=fabric, region=region, vertices=start, held=held, bodies=bodies, terms=tuple(terms)
    )
    return replace(prepared, vertices=_outside(prepared)) if scene.contact.start_outside else prepared


def with_loads(prepared: PreparedScene, scene: Scene) -> PreparedScene:
    """Return a scene on the same cloth and yarns with other attachments, bodies and contact; the region stays.

    The errors are the same as for ``prepare``.
    """
    cloth, laid = prepared.fabric.cloth, prepared.fabric.yarns
    held, bodies = _held(scene, cloth, laid), _bodies(scene)
    check_simulated(held, prepared.region)
    start = _disturbed(cloth, scene.disturbance)
    changed = replace(prepared, scene=scene, vertices=start, held=held, bodies=bodies)
    return replace(changed, vertices=_outside(changed)) if scene.contact.start_outside else changed


def with_region(prepared: PreparedScene, chosen: IntArray) -> PreparedScene:
    """Return a scene with yarns in other triangles.

    Args:
        prepared: the scene.
        chosen: numbers of the triangles with yarns alone.
    """
    fabric, section = prepared.fabric, prepared.scene.region
    layout = len(fabric.cloth.vertices), fabric.yarns.triangle, fabric.yarns.barycentric
    region = region_around(fabric.cloth.triangles, *layout, chosen, rings=section.rings)
    return replace(prepared, region=region)


def _outside(prepared: PreparedScene) -> FloatArray:
    """The vertices at the start, moved out of the bodies to the distance that contact keeps.

    Raises:
        ParameterError: a part of the cloth finds no way out.
    """
    worn = [WornBody(one.body, 0.5 * prepared.loads(0.0).thickness + one.thickness) for one in prepared.bodies]
    return dressed_vertices(
        prepared.fabric.cloth, prepared.vertices, worn, thickness=prepared.loads(0.0).thickness,
        device=device_named(prepared.scene.solver.device),
    )  # fmt: skip


def _layout(scene: Scene, cloth: Cloth) -> LaidYarns:
    """The yarns of a scene on its cloth."""
    free = host_memory()
    if scene.yarns.knit != STITCHES:
        check_layout_memory(scene.yarns.crossings_on(cloth), free)
        return scene.yarns.layout(cloth)
    fabric = scene.cloth.stitches()
    # a spline has about 16 control points for each stitch, including its row end
    per_stitch = 16.0 if scene.yarns.model == "splines" else 4.0 * scene.yarns.divisions**2
    check_layout_memory(per_stitch * fabric.face_count, free)
    if scene.yarns.model == "splines":
        from stitchmesh.mixed.scene.scene_splines import lay_scene_splines

        return lay_scene_splines(scene.yarns, fabric, cloth, scene.solver.device)
    width, height = scene.cloth.stitch_size(fabric)
    return lay_stitches(cloth, fabric, stitch_width=width, course_height=height, divisions=scene.yarns.divisions)


def _materials(section: YarnsSection, yarns: LaidYarns) -> FabricMaterials | SplineMaterial:
    """The material of the yarns; its kind belongs to their model."""
    if isinstance(yarns, SplineYarns):
        from stitchmesh.mixed.scene.scene_splines import spline_material

        return spline_material(section, float(yarns.curves.radius.mean()))
    return yarn_materials(section)


def yarn_materials(section: YarnsSection) -> FabricMaterials:
    """Return the materials of the crossing yarns of a scene.

    Raises:
        ParameterError: no material has the name.
        FileError: the file of materials cannot be read.
    """
    weft = _yarn_material(section, section.material)
    warp = weft if section.warp_material is None else _yarn_material(section, section.warp_material)
    return FabricMaterials(weft, warp, weft)


def _yarn_material(section: YarnsSection, name: str | None) -> CrossingMaterial:
    chosen = name or DEFAULT
    if section.material_file is None:
        material = CrossingMaterial.named(chosen)
    else:
        material = CrossingMaterial.read(section.material_file, chosen)
    chosen_radius = material if section.radius is None else replace(material, radius=section.radius)
    return chosen_radius.finer(section.density)


def cloth_of_weave(materials: FabricMaterials, ends: float, picks: float) -> ClothMaterial:
    """Return the material of a weave.

    Args:
        materials: materials of the yarns of the weave.
        ends: warps for each cm.
        picks: wefts for each cm.
    """
    weft, warp = materials.weft, materials.warp
    shear = 0.5 * (weft.shear + warp.shear) * weft.radius * warp.radius
    leg = 0.5 * (1.0 / ends + 1.0 / picks)
    bending = picks * weft.bending_stiffness, ends * warp.bending_stiffness
    return ClothMaterial(
        name="weave of straight yarns",
        stretch_course=picks * weft.stretch_stiffness,
        stretch_wale=ends * warp.stretch_stiffness,
        shear=4.0 * shear * leg * ends * picks,
        poisson=0.0,
        bending_course=bending[0],
        bending_wale=bending[1],
        density=picks * weft.density + ends * warp.density,
        twist=0.1 * (bending[0] * bending[1]) ** 0.5,
    )


def cloth_of_knit(material: CrossingMaterial, length: float) -> ClothMaterial:
    """Return a measured knit with the mass of the given yarn.

    Args:
        material: material of the yarn.
        length: length of yarn on each cm^2 of cloth [cm].
    """
    return replace(named_material("interlock"), density=material.density * length)


def _cloth_material(
    scene: Scene, cloth: Cloth, yarns: LaidYarns, materials: FabricMaterials | SplineMaterial, folder: Path | None,
    progress: Progress,
) -> ClothMaterial:  # fmt: skip
    if isinstance(yarns, SplineYarns) or isinstance(materials, SplineMaterial):
        if scene.cloth.material in (None, MATCHED):
            found = "none" if scene.cloth.material is None else repr(MATCHED)
            raise ParameterError(
                f"cloth.material: got {found} with B-spline yarns; expected a measured cloth or a file: "
                "'stitchmesh stretch' measures one"
            )
        return material_of(scene.cloth.material)
    if scene.cloth.material == MATCHED:
        from stitchmesh.mixed.scene.matched_cloth import cell_of_scene, matched_cloth

        stitch = None
        if scene.yarns.knit == STITCHES:
            width, height = scene.cloth.stitch_size(scene.cloth.stitches())
            stitch = width / scene.yarns.divisions, height / scene.yarns.divisions
        return matched_cloth(cell_of_scene(scene.yarns, stitch, materials), folder, progress)
    if scene.cloth.material is not None:
        return material_of(scene.cloth.material)
    if yarns.kind == "weave":
        return cloth_of_weave(
            materials, scene.yarns.density * scene.yarns.ends, scene.yarns.density * scene.yarns.picks
        )
    along = yarns.rest_sliding[yarns.yarn_node, yarns.yarn_coordinate]
    length = float(np.sum(along[yarns.yarn_start[1:] - 1] - along[yarns.yarn_start[:-1]]))
    return cloth_of_knit(materials.weft, length / float(cloth.rest_area.sum()))


def _seam_material(yarns: LaidYarns, materials: FabricMaterials | SplineMaterial) -> SeamMaterial | None:
    """Material of the rods where triangles are simulated, equal to the yarns that are rods; None without such yarns."""
    if isinstance(yarns, SplineYarns) or isinstance(materials, SplineMaterial) or ROD not in yarns.yarn_family:
        return None
    rod = materials.rod
    return SeamMaterial(rod.stretch_stiffness, rod.bending_stiffness, rod.density)


def _held(scene: Scene, cloth: Cloth, yarns: LaidYarns) -> tuple[Attachment, ...]:
    found: list[Attachment] = []
    for number, section in enumerate(scene.attachments):
        found.append(_attachment(number, section, cloth, yarns, tuple(found)))
    return tuple(found)


def _bodies(scene: Scene) -> tuple[LoadedBody, ...]:
    return tuple(LoadedBody(body=one.body(), friction=one.friction, thickness=one.thickness) for one in scene.bodies)


def _attachment(
    number: int, section: AttachmentSection, cloth: Cloth, yarns: LaidYarns, before: tuple[Attachment, ...]
) -> Attachment:
    """The vertices and layout nodes in the boxes of an attachment, and the free ones in its triangles."""
    name = f"attachments[{number}]"
    wrong = [vertex for vertex in section.vertices if not 0 <= vertex < len(cloth.vertices)]
    if wrong:
        raise ParameterError(f"{name}: got vertex {wrong[0]}; expected 0 to {len(cloth.vertices) - 1}")
    faces = np.array(section.faces, dtype=np.int64)
    absent = faces[(faces < 0) | (faces >= len(cloth.triangles))]
    if len(absent):
        raise ParameterError(f"{name}: got triangle {absent[0]}; expected 0 to {len(cloth.triangles) - 1}")
    vertices, nodes = _in_boxes(section, cloth, yarns)
    painted = np.unique(cloth.triangles[faces]), np.flatnonzero(np.isin(yarns.triangle, faces))
    for one in before:
        painted = np.setdiff1d(painted[0], one.vertices), np.setdiff1d(painted[1], one.nodes)
    vertices = np.union1d(np.union1d(vertices, painted[0]), np.array(section.vertices, dtype=np.int64))
    nodes = np.union1d(nodes, painted[1])
    if not len(vertices) + len(nodes) and not section.boxes:
        raise ParameterError(f"{name}: holds only what attachments before it hold; expected other triangles")
    if not len(vertices) + len(nodes):
        raise ParameterError(f"{name}: {section.boxes[0]}: holds nothing of the cloth; expected a box that overlaps it")
    return Attachment(vertices, nodes, section.motion(), name)


def check_simulated(held: tuple[Attachment, ...], region: Region) -> None:
    """Check that each attachment holds a part where yarns or triangles are simulated.

    Raises:
        ParameterError: an attachment holds no such part.
    """
    for each in held:
        if not region.unknown_vertices[each.vertices].any() and (region.node_number[each.nodes] < 0).all():
            raise ParameterError(
                f"{each.name}: holds {len(each.vertices)} vertices within the region of yarns and none of its yarn "
                "nodes; expected boxes that hold crossings of yarns too"
            )


def _in_boxes(section: AttachmentSection, cloth: Cloth, yarns: LaidYarns) -> tuple[IntArray, IntArray]:
    """Vertices and nodes in any of the boxes; a vertex counts with its place in each of its triangles."""
    corners, panel = cloth.triangles.ravel(), np.repeat(cloth.panel, 3)
    of_vertices, of_nodes = np.zeros(len(corners), dtype=bool), np.zeros(yarns.node_count, dtype=bool)
    for box in section.boxes:
        flat = cloth.rest.reshape(-1, 2)
        of_vertices |= box.holds(cloth.vertices[corners], panel, flat, cloth.panel_names)
        of_nodes |= box.holds(yarns.world(cloth), yarns.panel, yarns.position, cloth.panel_names)
    return np.unique(corners[of_vertices]), np.flatnonzero(of_nodes)


def _disturbed(cloth: Cloth, size: float) -> FloatArray:
    """The vertices, moved along the normals of their triangles by random parts of the given size."""
    if size == 0.0:
        return cloth.vertices
    normals = vertex_normals(cloth.triangles, cloth.vertices)
    part = np.random.default_rng(0).uniform(-1.0, 1.0, len(normals))
    moved: FloatArray = cloth.vertices + size * part[:, None] * normals
    return moved
