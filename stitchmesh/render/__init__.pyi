# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from .any_picture import render as render
from .fabric_pictures import render_faces as render_faces
from .fabric_pictures import render_mesh as render_mesh
from .fabric_pictures import render_rows as render_rows
from .fabric_pictures import render_stitches as render_stitches
from .fabric_pictures import render_stretch as render_stretch
from .gl_probe import check_display as check_display
from .options import PictureOptions as PictureOptions
from .picture import render_yarns as render_yarns
from .swatch_picture import render_swatch as render_swatch
