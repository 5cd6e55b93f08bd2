# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn generation: from stitch faces to yarn curves (Yuksel et al. 2012, sections 4 and 6.2)."""

from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.generate import generate_yarns, mean_stitch_width
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from stitchmesh.yarngen.loop_ownership import in_heads
from stitchmesh.yarngen.regenerate import regenerate_yarns

__all__ = ["YarnFinish", "check_loops", "generate_yarns", "in_heads", "mean_stitch_width", "regenerate_yarns"]
