# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of a checkpoint, which show a relaxation that runs or was stopped."""

from __future__ import annotations

from dataclasses import replace
from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.checkpoint_file import read_checkpoint
from stitchmesh.io.contents import FilePath, check_points
from stitchmesh.io.float32 import from_float32
from stitchmesh.yarn import YarnSet


def checkpoint_yarns(path: FilePath, yarns: YarnSet) -> YarnSet:
    """Return yarns at the last good positions of a checkpoint.

    A checkpoint holds positions in mean yarn radii, from the middle of the yarns that were given to the relaxation. The
    returned yarns have the same middle as ``yarns``.

    Args:
        path: a checkpoint (``.smc``).
        yarns: the yarns of the relaxation, at any positions.

    Raises:
        FileError: the checkpoint cannot be read, or belongs to other yarns.
    """
    content = read_checkpoint(path)
    points = from_float32(content.arrays.get("good_points", np.zeros((0, 3))))
    count = len(yarns.points)
    if points.ndim != 2 or not count <= len(points) <= count + 3:  # Strains of a relaxing cell follow the points.
        found = f"holds {len(points)} control points"
        raise FileError(f"{fspath(path)}: {found}; expected the {count} of the yarns in the same folder")
    placed = points[:count] * float(yarns.radius.mean())
    middle = (yarns.points.min(axis=0) + yarns.points.max(axis=0)) / 2
    check_points(f"{fspath(path)}: control point", placed)
    return replace(yarns, points=placed + middle - (placed.min(axis=0) + placed.max(axis=0)) / 2)
