# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of meshes, fabrics and yarns, drawn off screen."""

from stitchmesh.viewer.fabric_pictures import render_mesh, render_rows, render_stitches, render_stretch
from stitchmesh.viewer.file_picture import render_file
from stitchmesh.viewer.gl_probe import check_display
from stitchmesh.viewer.picture import render_yarns
from stitchmesh.viewer.swatch_picture import render_swatch

__all__ = [
    "check_display",
    "render_file",
    "render_mesh",
    "render_rows",
    "render_stitches",
    "render_stretch",
    "render_swatch",
    "render_yarns",
]
