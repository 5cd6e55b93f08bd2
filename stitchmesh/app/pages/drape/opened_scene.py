# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A scene with what is made of it: the cloth as a mesh, its yarns, the region and what the region costs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.compute.free_memory import available_memory
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import IntArray, Mesh, StitchMesh
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.memory import estimate_memory
from stitchmesh.mixed.output.report import region_counts
from stitchmesh.mixed.scene.cloth_section import STITCH_SUFFIXES
from stitchmesh.mixed.scene.region_section import RegionSection, marked_triangles
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, check_simulated, prepare, with_loads
from stitchmesh.progress import Progress, no_progress

LOADS = ("attachments", "bodies", "contact", "disturbance")
"""Fields of a scene that act on the cloth and its yarns and do not change them."""
NO_TRIANGLES = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class OpenedScene:
    """A scene that can be shown and changed."""

    prepared: PreparedScene
    """The scene, with cloth, yarns and region."""
    mesh: Mesh
    """The triangles of the cloth at the start, by their numbers."""
    fabric: StitchMesh | None
    """The stitches of the cloth, if it is one of stitches."""
    trouble: str = ""
    """Why the region of the scene is not possible; empty if it is."""

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.prepared.scene

    @property
    def cloth(self) -> Cloth:
        """The cloth."""
        return self.prepared.fabric.cloth

    @property
    def region(self) -> Region:
        """The region; that of an automatic one has no yarns before a run."""
        return self.prepared.region

    @cached_property
    def marked(self) -> IntArray:
        """The triangles that the scene marks, ascending: those of yarns, or where an automatic region may be."""
        try:
            return marked_triangles(self.scene.region, self.cloth)
        except StitchMeshError:
            return NO_TRIANGLES  # The trouble says why.

    @cached_property
    def counts(self) -> dict[str, int]:
        """Numbers of nodes and vertices, as in the report of a run."""
        return region_counts(self.cloth, self.prepared.fabric.yarns, self.region)

    @cached_property
    def memory(self) -> float:
        """Estimated memory of a run [bytes]."""
        scene = self.scene
        return estimate_memory(self.region, contact=bool(scene.bodies) or scene.contact.self_collision).total

    def free_memory(self) -> float:
        """Return the memory that is free where the scene would run [bytes]."""
        return available_memory(device_named(self.scene.solver.device))


def open_scene(scene: Scene, folder: Path | None = None, progress: Progress = no_progress) -> OpenedScene:
    """Make what a scene describes; a region that is not possible is left out, and its ``trouble`` kept.

    Args:
        scene: the scene.
        folder: where a material that is matched to the yarns is kept, and found again.
        progress: called with the completed part of the matching.

    Raises:
        StitchMeshError: anything else in the scene is not possible, or a file cannot be read.
    """
    prepared = prepare(replace(scene, region=RegionSection()), folder=folder, progress=progress)
    mesh = Mesh.from_polygons(prepared.vertices, prepared.fabric.cloth.triangles.tolist())
    name = scene.cloth.file
    fabric = scene.cloth.stitches() if name is not None and Path(name).suffix.lower() in STITCH_SUFFIXES else None
    return with_region(OpenedScene(prepared, mesh, fabric), scene.region)


def with_scene(
    opened: OpenedScene, scene: Scene, folder: Path | None = None, progress: Progress = no_progress
) -> OpenedScene:
    """Return another scene; what both share is not made again.

    Other arguments and errors are those of ``open_scene``.
    """
    before = opened.scene
    if scene.cloth != before.cloth or scene.yarns != before.yarns:
        return open_scene(scene, folder, progress)
    prepared, mesh = replace(opened.prepared, scene=scene), opened.mesh
    if any(getattr(scene, name) != getattr(before, name) for name in LOADS):
        prepared = with_loads(replace(prepared, region=prepared.without_yarns), scene)
        if not np.array_equal(prepared.vertices, mesh.vertices):
            mesh = Mesh.from_polygons(prepared.vertices, prepared.fabric.cloth.triangles.tolist())
    return with_region(replace(opened, prepared=prepared, mesh=mesh), scene.region)


def with_region(opened: OpenedScene, section: RegionSection) -> OpenedScene:
    """Return the scene with another region."""
    scene = replace(opened.scene, region=section)
    yarns = opened.prepared.fabric.yarns
    region, trouble = RegionSection().region(opened.cloth, yarns), ""
    try:
        marked_triangles(section, opened.cloth)
        region = section.region(opened.cloth, yarns)
        check_simulated(opened.prepared.held, region)
    except StitchMeshError as error:
        trouble = str(error)
    return replace(opened, prepared=replace(opened.prepared, scene=scene, region=region), trouble=trouble)
