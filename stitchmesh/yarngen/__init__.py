# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn generation: from stitch faces to yarn curves (Yuksel et al. 2012, sections 4 and 6.2)."""

from stitchmesh.yarngen.generate import generate_yarns, mean_stitch_width

__all__ = ["generate_yarns", "mean_stitch_width"]
