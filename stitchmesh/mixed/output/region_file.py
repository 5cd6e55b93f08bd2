# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The region at the start of a run in its output folder.

A scene with an automatic region does not say where the yarns are. The kinds of the triangles and the blending field
therefore stand in a file of their own; frames hold those of their own times.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import fspath
from pathlib import Path

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.hdf5 import read_dataclass, write_dataclass
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.layout.laid_yarns import LaidYarns

NAME = "region.h5"
"""Name of the file in the output folder."""
FORMAT = "stitchmesh mixed region"
"""Attribute ``format`` of the file."""


@dataclass(frozen=True, eq=False)
class RegionFields:
    """What a region adds to a cloth and its yarns."""

    triangle_kind: IntArray
    """Kind of each triangle, shape (T,)."""
    vertex_alpha: FloatArray
    """The blending field at the vertices, shape (V,)."""
    smallest_alpha: FloatArray
    """Smallest weight of a yarn element, shape (1,)."""


def write_region(folder: Path, region: Region) -> None:
    """Write the region of a run into its output folder.

    Raises:
        FileError: the file cannot be written.
    """
    found = RegionFields(region.triangle_kind, region.vertex_alpha, np.array([region.smallest_alpha]))
    write_dataclass(folder / NAME, found, FORMAT)


def read_region(folder: Path, cloth: Cloth, yarns: LaidYarns) -> Region:
    """Read the region of a run from its output folder.

    Raises:
        FileError: the file is missing or damaged, or belongs to another cloth.
    """
    path = folder / NAME
    found = read_dataclass(path, RegionFields, FORMAT)
    kind, alpha = found.triangle_kind, found.vertex_alpha
    if (len(kind), len(alpha)) != (len(cloth.triangles), len(cloth.vertices)):
        sizes = f"is of {len(kind)} triangles and {len(alpha)} vertices"
        expected = f"{len(cloth.triangles)} and {len(cloth.vertices)}, as in the scene beside it"
        raise FileError(f"{fspath(path)}: {sizes}; expected {expected}")
    smallest = float(found.smallest_alpha[0])
    return Region(np.array(cloth.triangles), yarns.triangle, yarns.barycentric, kind, alpha, smallest)
