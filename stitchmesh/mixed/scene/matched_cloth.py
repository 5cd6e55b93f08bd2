# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The material of triangles that is matched to the yarns of a scene (``matching``).

A file beside the output keeps the material and a checksum of the repeat of the fabric, so that a scene with other yarns
is matched again. Stitches of a stitch mesh count as plain knit.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

from numpy.typing import ArrayLike

from stitchmesh.errors import FileError
from stitchmesh.io.path_kind import is_there
from stitchmesh.mixed.crossings.crossing_material import FabricMaterials
from stitchmesh.mixed.matching.cloth_match import ClothMatch, match_cloth, write_match
from stitchmesh.mixed.matching.yarn_cell import YarnCell, knit_cell, weave_cell
from stitchmesh.mixed.scene.scene import YarnsSection, knit_chart, weave_matrix
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.material_file import read_material
from stitchmesh.progress import Progress
from stitchmesh.yarnrelax.fingerprint import fingerprint

NAME = "matched-cloth.toml"
"""Name of the file in the output folder."""
CHECKSUM = "checksum"
"""Word that precedes the checksum in the source of the material."""
_known: dict[str, ClothMatch] = {}
"""Matches of this process, by the checksums of their cells."""


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
