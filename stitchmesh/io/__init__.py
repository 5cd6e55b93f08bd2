# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files: polygon meshes, stitch meshes and yarns; one format per module, all writes atomic."""

from stitchmesh.io.meshes import read_mesh, write_mesh
from stitchmesh.io.stitches import read_stitches, write_stitches
from stitchmesh.io.yarns import read_yarns, write_yarns

__all__ = ["read_mesh", "read_stitches", "read_yarns", "write_mesh", "write_stitches", "write_yarns"]
