# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces of triangles that follow no rows of knitting, from simple shapes to garments as they are worn."""

from __future__ import annotations

from collections.abc import Callable

from stitchmesh.mesh import Mesh

from .flat_sheets import SHEETS, moebius_polygons
from .simple_surfaces import SIMPLE
from .soft_toys import TOYS
from .triangulation import triangulated
from .worn_garments import WORN

SHAPES: dict[str, Callable[[], Mesh]] = {shape.__name__: shape for shape in (*SIMPLE, *SHEETS, *WORN, *TOYS)}
"""All shapes by the names of their functions, which also take the length of edges [cm]."""

__all__ = ["SHAPES", "moebius_polygons", "triangulated"]
