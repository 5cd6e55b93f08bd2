# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Off-screen pictures of meshes, fabrics and yarns."""

from stitchmesh.render.fabric_pictures import render_mesh, render_rows, render_stitches, render_stretch
from stitchmesh.render.file_picture import render_file
from stitchmesh.render.gl_probe import check_display
from stitchmesh.render.picture import render_yarns
from stitchmesh.render.swatch_picture import render_swatch

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
