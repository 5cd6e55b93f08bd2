# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn evened out along each stitch, so that a spline does not stretch here and there while its length is right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import StitchMesh
from stitchmesh.rest_length import segment_faces
from stitchmesh.stitch import Stitch
from stitchmesh.yarn import UNKNOWN_FACE, YarnSet
from stitchmesh.yarngen.table import template


def evened(yarns: YarnSet, fabric: StitchMesh) -> YarnSet:
    """Yarns whose segments are equally long at rest within each stitch.

    A stitch's own yarn and that of the loops below, which its face holds too, are evened apart, each as long as it was.
    So all copies of a stitch are alike, whether the loops below are of another yarn, of another image of the same one
    or of the next column's.

    Args:
        yarns: generated from the fabric.
        fabric: stitches without borders.
    """
    stitch = yarns.segment_yarn * (yarns.face.max() + 2) + segment_faces(yarns) - UNKNOWN_FACE
    group = np.stack([stitch, _of_loop_below(yarns, fabric)], axis=1)
    _, run, count = np.unique(group, axis=0, return_inverse=True, return_counts=True)
    return replace(yarns, rest_length=(np.bincount(run, yarns.rest_length) / count)[run])


def _of_loop_below(yarns: YarnSet, fabric: StitchMesh) -> NDArray[np.bool_]:
    """Whether each segment is yarn of a loop below its stitch, shape (S,); rows do not tell in a cell of one row."""
    point = yarns.segment_points[:, 1]
    face = yarns.face[point]
    kinds = np.stack([fabric.stitch[face], fabric.n_bottom[face], fabric.n_top[face], yarns.part[point]], axis=1)
    unique, kind = np.unique(kinds, axis=0, return_inverse=True)
    is_head = [template(Stitch(code), *sides).parts[part].is_head for code, *sides, part in unique.tolist()]
    return np.array(is_head)[kind]
