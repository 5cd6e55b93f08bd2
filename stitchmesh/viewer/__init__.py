# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of yarns and fabrics, drawn off screen."""

from stitchmesh.viewer.gl_probe import check_display
from stitchmesh.viewer.picture import render_yarns

__all__ = ["check_display", "render_yarns"]
