# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tessellation of labeled panels into stitch faces (Yuksel et al. 2012, section 5.2)."""

from stitchmesh.tessellate.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH, tessellate

__all__ = ["COURSE_OVER_WALE_SPACING", "STITCH_WIDTH", "tessellate"]
