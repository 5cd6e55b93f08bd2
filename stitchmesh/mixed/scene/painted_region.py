# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles that are added to the region of a scene, or taken out of it, as a brush does.

Boxes stay boxes as long as they keep all their triangles, so that a scene stays readable; a box that loses a triangle
becomes the numbers of the others.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.mesh import IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.scene.region_section import RegionSection


def marked_triangles(section: RegionSection, cloth: Cloth) -> IntArray:
    """Return the triangles that a section marks, ascending: those of yarns, or where an automatic region may be.

    Raises:
        ParameterError: as for ``RegionSection.triangles``.
    """
    return section.named_triangles(cloth) if section.yarns == "automatic" else section.triangles(cloth)


def with_triangles(section: RegionSection, cloth: Cloth, triangles: ArrayLike) -> RegionSection:
    """Return a section that marks more triangles.

    A region of yarns nowhere or everywhere becomes a chosen one first; an automatic region stays automatic, and the
    triangles are those where it may have yarns.

    Args:
        section: the section.
        cloth: the cloth.
        triangles: numbers of triangles, shape (n,).

    Raises:
        ParameterError: a box holds no triangle.
    """
    chosen = _as_chosen(section, cloth)
    new = np.setdiff1d(np.asarray(triangles, dtype=np.int64), chosen.named_triangles(cloth))
    return replace(chosen, faces=_numbers(np.union1d(np.array(chosen.faces, dtype=np.int64), new)))


def without_triangles(section: RegionSection, cloth: Cloth, triangles: ArrayLike) -> RegionSection:
    """Return a section that does not mark some triangles; arguments as for ``with_triangles``.

    Raises:
        ParameterError: a box holds no triangle.
    """
    chosen = _as_chosen(section, cloth)
    removed = np.asarray(triangles, dtype=np.int64)
    kept, faces = [], np.array(chosen.faces, dtype=np.int64)
    for box in chosen.boxes:
        held = RegionSection(boxes=(box,)).named_triangles(cloth)
        if np.isin(held, removed).any():
            faces = np.union1d(faces, held)
        else:
            kept.append(box)
    return replace(chosen, boxes=tuple(kept), faces=_numbers(np.setdiff1d(faces, removed)))


def _as_chosen(section: RegionSection, cloth: Cloth) -> RegionSection:
    """The section as one whose boxes and faces count."""
    if section.yarns == "none":
        return replace(section, yarns="chosen", boxes=(), faces=())
    if section.yarns == "all":
        return replace(section, yarns="chosen", boxes=(), faces=_numbers(section.triangles(cloth)))
    return section


def _numbers(triangles: IntArray) -> tuple[int, ...]:
    return tuple(triangles.tolist())
