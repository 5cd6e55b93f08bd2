# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Off-screen pictures of meshes, fabrics and yarns."""

from stitchmesh.render.any_picture import render
from stitchmesh.render.fabric_pictures import render_faces, render_mesh, render_rows, render_stitches, render_stretch
from stitchmesh.render.gl_probe import check_display
from stitchmesh.render.options import PictureOptions
from stitchmesh.render.picture import render_yarns
from stitchmesh.render.swatch_picture import render_swatch

__all__ = [
    "PictureOptions",
    "check_display",
    "render",
    "render_faces",
    "render_mesh",
    "render_rows",
    "render_stitches",
    "render_stretch",
    "render_swatch",
    "render_yarns",
]
