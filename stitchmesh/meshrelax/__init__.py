# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation: equalize the sizes of the stitches on a surface (Yuksel et al. 2012, section 6.1)."""

from stitchmesh.meshrelax.relax import MeshRelaxReport, relax_mesh, relax_mesh_with_report

__all__ = ["MeshRelaxReport", "relax_mesh", "relax_mesh_with_report"]
