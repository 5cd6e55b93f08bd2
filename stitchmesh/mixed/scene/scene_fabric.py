# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Makes the parts of a simulation from a scene: the fabric, its region, its loads and all positions at the start.

The B-spline yarns of a scene are generated from the stitches of its cloth, relaxed, and laid out on the cloth. The
relaxation keeps the borders and the shape of the stitch mesh, so the yarns lie where their stitches are. It gives all
yarns the shape of loops at rest, also where triangles are simulated and yarns are only shown.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.compute.free_memory import host_memory
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mixed.assembly import LoadedBody, Loads, MixedFabric
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.contact.dressing import WornBody, dressed_vertices
from stitchmesh.mixed.contact.motion import Attachment
from stitchmesh.mixed.contact.self_collision import PRESSURE
from stitchmesh.mixed.crossings.crossing_material import DEFAULT, CrossingMaterial, FabricMaterials
from stitchmesh.mixed.enrichment.region import Region, region_around
from stitchmesh.mixed.layout.crossing_yarns import ROD
from stitchmesh.mixed.layout.curves import vertex_normals
from stitchmesh.mixed.layout.from_stitches import lay_stitches
from stitchmesh.mixed.layout.spline_yarns import LaidYarns, SplineYarns, lay_splines
from stitchmesh.mixed.memory import check_layout_memory
from stitchmesh.mixed.scene.cloth_of_yarns import MATCHED, cell_of_scene, cloth_of_knit, cloth_of_weave, matched_cloth
from stitchmesh.mixed.scene.motion_section import AttachmentSection
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.yarns_section import STITCHES, YarnsSection
from stitchmesh.mixed.splines.spline_pieces import SplineMaterial
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.material_file import material_of
from stitchmesh.mixed.triangles.seam_rod import SeamMaterial
from stitchmesh.progress import Progress, no_progress
from stitchmesh.quality import quality_named
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.model.material import DEFAULT_MATERIAL

QUALITY = replace(quality_named("draft"), contact_samples=SplineMaterial.contact_samples)
"""Quality of the yarns: 12 control points for each stitch. The loops of a swatch are then 1 % larger than at quality
``reference``."""


def lay_scene_splines(section: YarnsSection, fabric: StitchMesh, cloth: Cloth, device: str | None) -> SplineYarns:
    """Return the B-spline yarns of a scene.

    Args:
        section: the yarns of the scene.
        fabric: the stitch mesh of the cloth of the scene.
        cloth: the cloth of the stitch mesh.
        device: name of the device that relaxes the yarns; by default a GPU if there is one.

    Raises:
        ParameterError: a radius or a loop length does not fit the stitches.
        YarnError: a stitch has no yarn.
        SolverError: the yarns are too close to one another.
    """
    curves = drawn_splines(section, fabric)
    material = spline_material(section, float(curves.radius.mean())).yarn
    relaxed = relax_yarns(curves, material=material, quality=QUALITY, keep_shape=fabric, device=device, run=QUIET)
    return lay_splines(cloth, fabric, relaxed.yarns)


def drawn_splines(section: YarnsSection, fabric: StitchMesh) -> YarnSet:
    """Return the B-spline yarns as generated, with rest lengths; arguments and errors as in ``lay_scene_splines``."""
    drawn = generate_yarns(fabric, yarn_radius=section.radius, quality=QUALITY)
    return apply_rest_lengths(drawn, RestLengths(loop_length=section.loop_length), fabric=fabric)


def spline_material(section: YarnsSection, radius: float) -> SplineMaterial:
    """Return the material of the B-spline yarns of a scene, for their radius [cm].

    Raises:
        ParameterError: there is no material of that name.
    """
    return SplineMaterial.named(section.material or DEFAULT_MATERIAL, radius=radius)


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
        )

    @property
    def releases(self) -> list[float]:
        """Times at which attachments are released [s], ascending."""
        return sorted({one.release for one in self.scene.attachments if one.release is not None})


def prepare(
    scene: Scene, *, cloth: Cloth | None = None, yarns: LaidYarns | None = None,
    folder: Path | None = None, progress: Progress = no_progress,
) -> PreparedScene:  # fmt: skip
    """Make the parts of the simulation of a scene.

    Args:
        scene: the scene.
        cloth: a cloth that replaces the cloth of the scene.
        yarns: yarns laid out on this cloth, which replace the yarns of the scene.
        folder: where a material that is matched to the yarns is kept and found again.
        progress: called with the completed part of the matching and a line of text.

    Raises:
        ParameterError: a name is unknown, a box holds nothing, or a setting is not possible.
        FileError: a file cannot be read.
        MeshError: the panels or a body do not form a surface as expected.
    """
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
    prepared = PreparedScene(scene=scene, fabric=fabric, region=region, vertices=start, held=held, bodies=bodies)
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
        return lay_scene_splines(scene.yarns, fabric, cloth, scene.solver.device)
    width, height = scene.cloth.stitch_size(fabric)
    return lay_stitches(cloth, fabric, stitch_width=width, course_height=height, divisions=scene.yarns.divisions)


def _materials(section: YarnsSection, yarns: LaidYarns) -> FabricMaterials | SplineMaterial:
    """The material of the yarns; its kind belongs to their model."""
    if isinstance(yarns, SplineYarns):
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
