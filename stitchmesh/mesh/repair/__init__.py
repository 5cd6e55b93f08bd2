# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Valid meshes from the polygons and triangles that modelling programs write, and the search for self-intersections."""

from stitchmesh.mesh.repair.action import RepairAction, RepairOptions
from stitchmesh.mesh.repair.repair import DEFAULT_REPAIR, Repaired, repair_mesh
from stitchmesh.mesh.repair.self_intersections import self_intersections

__all__ = ["DEFAULT_REPAIR", "RepairAction", "RepairOptions", "Repaired", "repair_mesh", "self_intersections"]
