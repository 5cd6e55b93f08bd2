# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A scene from a file, or a new one for a cloth, with its mesh, its yarns, its region and its costs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from os import fspath
from pathlib import Path

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.compute.free_memory import available_memory
from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.toml_file import read_table
from stitchmesh.mesh import IntArray, Mesh, StitchMesh
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.crossings.crossing_material import DEFAULT, CrossingMaterial
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.memory import estimate_memory
from stitchmesh.mixed.output.report import region_counts
from stitchmesh.mixed.scene.motion_section import AttachmentSection
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection, marked_triangles
from stitchmesh.mixed.scene.scene import (
    STITCH_SUFFIXES,
    ClothSection,
    Scene,
    SceneSolverSection,
    YarnsSection,
    read_scene,
)
from stitchmesh.mixed.scene.scene_fabric import STITCHES, PreparedScene, check_simulated, prepare, with_loads
from stitchmesh.progress import Progress, no_progress

SUFFIXES = (".toml", ".obj", *STITCH_SUFFIXES)
"""Suffixes of the files that can be opened."""
HELD = 1.1
"""Height of the held strip at the top of a new cloth, over the mean length of an edge. The loops of the last row of a
knit cross the others near the bottom of their stitches."""
BESIDE = 1.0
"""Distance by which the box of the held part is larger than the cloth [cm]."""


def scene_of_file(path: Path) -> Scene:
    """Return the scene of a file, or a new scene for the cloth of a file.

    The upper border of a new cloth is held, and gravity acts. Its yarns are a plain weave, or the stitches of the file;
    friction holds these where they cross.

    Raises:
        FileError: the file cannot be read.
        ParameterError: a panel or a texture coordinate is not valid.
        MeshError: the cloth is no surface.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise FileError(f"{path.name}: got the suffix {suffix!r}; expected one of {', '.join(SUFFIXES)}")
    if suffix == ".toml" and "cloth" in read_table(path):
        return read_scene(path)
    section = ClothSection(file=fspath(path.absolute()))
    cloth = section.cloth()
    is_knit = suffix in STITCH_SUFFIXES
    yarns = stitch_yarns(section) if is_knit else YarnsSection(weave="plain")
    # A knit whose yarns may slide takes several times as long to come to rest.
    solver = SceneSolverSection(force_tolerance=0.1, friction_updates=0) if is_knit else SceneSolverSection()
    return Scene(cloth=section, yarns=yarns, attachments=(held_at_top(cloth),), solver=solver)


def stitch_yarns(section: ClothSection) -> YarnsSection:
    """Return the yarns of a cloth of stitches, with the number of loops in each stitch that the scene's yarn fills."""
    width, _ = section.stitch_size(section.stitches())
    loops = width / (8.0 * CrossingMaterial.named(DEFAULT).radius)  # a loop is eight radii of its yarn wide
    return YarnsSection(knit=STITCHES, divisions=min(max(round(loops), 1), 4))


def held_at_top(cloth: Cloth) -> AttachmentSection:
    """Return an attachment that holds the uppermost part of a cloth."""
    low, high = cloth.vertices.min(axis=0) - BESIDE, cloth.vertices.max(axis=0) + BESIDE
    ends = cloth.vertices[cloth.side_vertices]
    edge = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean())
    low[1] = cloth.vertices[:, 1].max() - HELD * edge
    first, last = np.round(low, 4).tolist(), np.round(high, 4).tolist()
    return AttachmentSection(boxes=(BoxSection(low=tuple(first), high=tuple(last)),))


LOADS = ("attachments", "bodies", "contact", "disturbance")
"""Fields of a scene that act on the cloth and its yarns without changing them."""
NO_TRIANGLES = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class OpenedScene:
    """A scene that the page can show and change."""

    prepared: PreparedScene
    """The scene, with cloth, yarns and region."""
    mesh: Mesh
    """The triangles of the cloth at the start, by their numbers."""
    fabric: StitchMesh | None
    """The stitches of the cloth; None for any other cloth."""
    trouble: str = ""
    """Why the region of the scene is not possible; empty if it is possible."""

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
        """The region; an automatic region has no yarns before a run."""
        return self.prepared.region

    @cached_property
    def marked(self) -> IntArray:
        """The triangles that the scene marks, ascending: those with yarns, or those allowed to an automatic region."""
        try:
            return marked_triangles(self.scene.region, self.cloth)
        except StitchMeshError:
            return NO_TRIANGLES  # ``trouble`` says why.

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
        """Return the free memory where the scene would run [bytes]."""
        return available_memory(device_named(self.scene.solver.device))


def open_scene(scene: Scene, folder: Path | None = None, progress: Progress = no_progress) -> OpenedScene:
    """Build the objects of a scene; an impossible region is left out, and ``trouble`` says why.

    Args:
        scene: the scene.
        folder: the place where a material that was matched to the yarns is kept and found again.
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
    """Return another scene; it takes over the objects that both scenes share.

    Other arguments and errors as for ``open_scene``.
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
