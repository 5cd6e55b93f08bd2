# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A material of cloth for scenes that name none: it follows from a weave of straight yarns.

With e warps and p wefts per cm, and for each family of yarns the stiffnesses of stretch k_s and of bending k_b, the
shear stiffness k_x of a quadrant, and the linear density rho (Cirio et al. 2014):

    stretch p k_s, e k_s    [dyn/cm],     bending p k_b, e k_b    [dyn cm],     density p rho + e rho    [g/cm^2],
    shear 4 k_x L e p       [dyn/cm],     because each crossing has four quadrants, and L is the mean of their legs.

Crossings turn freely about the normal, so only the shear of quadrants resists twist; the twist rigidity is set to a
tenth of the geometric mean of both rigidities. Sliding, crimp and contact of yarns are left out: a material that is
fitted to the yarns (``matching``) agrees better.

``matched_cloth`` returns the material of triangles that is matched to the yarns of a scene (``matching``). A file
beside the output keeps the material and a checksum of the repeat of the fabric, so that a scene with other yarns is
matched again. Stitches of a stitch mesh count as plain knit.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

from numpy.typing import ArrayLike

from stitchmesh.errors import FileError
from stitchmesh.io.path_kind import is_there
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.matching.cloth_match import ClothMatch, match_cloth, write_match
from stitchmesh.mixed.matching.yarn_cell import YarnCell, knit_cell, weave_cell
from stitchmesh.mixed.scene.yarns_section import YarnsSection, knit_chart, weave_matrix
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.material_file import named_material, read_material
from stitchmesh.progress import Progress
from stitchmesh.yarnrelax.fingerprint import fingerprint

MATCHED = "matched"
"""Name of the cloth material that is matched to the yarns of the scene."""
NAME = "matched-cloth.toml"
"""Name of the file in the output folder."""
CHECKSUM = "checksum"
"""Word that precedes the checksum in the source of the material."""
_known: dict[str, ClothMatch] = {}
"""Matches of this process, by the checksums of their cells."""


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


def matched_cloth(cell: YarnCell, folder: Path | None, progress: Progress) -> ClothMaterial:
    """Return the material matched to a repeat of yarns.

    Args:
        cell: the repeat.
        folder: where the material is kept and found again; None keeps it only in memory.
        progress: called with the completed part and the name of the test.

    Raises:
        SolverError: a state of the repeat finds no equilibrium.
        FileError: the file cannot be written.
    """
    inputs = hashlib.sha256(repr(sorted(fingerprint("cell", cell).items())).encode()).hexdigest()[:16]
    kept = None if folder is None else _kept(folder / NAME, inputs)
    if kept is not None:
        return kept
    if inputs not in _known:
        _known[inputs] = _matched(cell, inputs, progress)
    if folder is not None:
        write_match(folder / NAME, _known[inputs])
    return _known[inputs].material


def cell_of_scene(section: YarnsSection, stitch: tuple[float, float] | None, materials: FabricMaterials) -> YarnCell:
    """Return the repeat of the yarns of a scene.

    Args:
        section: the yarns.
        stitch: wale and course spacing [cm], if the yarns are the stitches of the cloth.
        materials: materials of the yarns.

    Raises:
        ParameterError: the weave or the pattern is unknown.
    """
    n = section.density
    if section.weave is not None:
        matrix = weave_matrix(section.weave)
        return weave_cell(matrix, ends=n * section.ends, picks=n * section.picks, materials=materials)
    spacing = stitch or (1.0 / (n * section.wales), 1.0 / (n * section.courses))
    # the stitches of a stitch mesh count as plain knit
    chart: ArrayLike = [[1]] if stitch is not None or section.knit is None else knit_chart(section.knit)
    return knit_cell(chart, wale_spacing=spacing[0], course_spacing=spacing[1], materials=materials)


def _matched(cell: YarnCell, inputs: str, progress: Progress) -> ClothMatch:
    """Run the tests of the yarns and fit the material; its source names the checksum."""
    match = match_cloth(cell, progress=progress)
    linear, tables = (
        replace(each, source=f"{each.source}; {CHECKSUM} {inputs}") for each in (match.linear, match.tables)
    )
    return replace(match, linear=linear, tables=tables)


def _kept(path: Path, inputs: str) -> ClothMaterial | None:
    """The material of a file, if it belongs to the same repeat."""
    if not is_there(path):
        return None
    try:
        material = read_material(path)
    except FileError:
        return None
    return material if material.source.endswith(f"{CHECKSUM} {inputs}") else None
