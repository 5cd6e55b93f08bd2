# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files as scenes: a scene as it is, panels, meshes and stitches as the cloth of a new one."""

from __future__ import annotations

from os import fspath
from pathlib import Path

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.toml_file import read_table
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.crossings.crossing_material import DEFAULT, CrossingMaterial
from stitchmesh.mixed.scene.cloth_section import STITCH_SUFFIXES, ClothSection
from stitchmesh.mixed.scene.motion_section import AttachmentSection
from stitchmesh.mixed.scene.region_section import BoxSection
from stitchmesh.mixed.scene.scene import Scene, SolverSection
from stitchmesh.mixed.scene.scene_fabric import STITCHES
from stitchmesh.mixed.scene.scene_file import read_scene
from stitchmesh.mixed.scene.yarns_section import YarnsSection

SUFFIXES = (".toml", ".obj", *STITCH_SUFFIXES)
"""Suffixes of the files that can be opened."""
HELD = 1.1
"""Height of what is held at the top of a new cloth over the mean length of an edge; the loops of the last row of a knit
cross the others near the bottom of their stitches."""
LOOP = 8.0
"""Width of a loop over the radius of its yarn."""
MOST_LOOPS = 4
"""Most loops along each side of a stitch of a new cloth."""
KNIT_TOLERANCE = 0.1
"""Largest unbalanced force at the equilibrium of a new knitted cloth [dyn]."""
BESIDE = 1.0
"""Distance by which the box around what is held is larger than the cloth [cm]."""


def scene_of_file(path: Path) -> Scene:
    """Return the scene of a file, or a new scene whose cloth is in the file.

    The upper border of a new cloth is held, and gravity acts; its yarns are a plain weave, or the stitches of the file,
    held by friction where they cross.

    Raises:
        FileError: the file cannot be read.
        ParameterError: a panel or a texture coordinate is not possible.
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
    solver = SolverSection(force_tolerance=KNIT_TOLERANCE, friction_updates=0) if is_knit else SolverSection()
    return Scene(cloth=section, yarns=yarns, attachments=(held_at_top(cloth),), solver=solver)


def stitch_yarns(section: ClothSection) -> YarnsSection:
    """Return the yarns of a cloth of stitches: so many loops in each stitch that the yarn of the scene fills them."""
    width, _ = section.stitch_size(section.stitches())
    loops = width / (LOOP * CrossingMaterial.named(DEFAULT).radius)
    return YarnsSection(knit=STITCHES, divisions=min(max(round(loops), 1), MOST_LOOPS))


def held_at_top(cloth: Cloth) -> AttachmentSection:
    """Return an attachment that holds the uppermost part of a cloth."""
    low, high = cloth.vertices.min(axis=0) - BESIDE, cloth.vertices.max(axis=0) + BESIDE
    ends = cloth.vertices[cloth.side_vertices]
    edge = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean())
    low[1] = cloth.vertices[:, 1].max() - HELD * edge
    first, last = np.round(low, 4).tolist(), np.round(high, 4).tolist()
    return AttachmentSection(boxes=(BoxSection(low=tuple(first), high=tuple(last)),))
