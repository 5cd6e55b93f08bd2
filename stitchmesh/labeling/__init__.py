# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Labeling: which edges of a mesh are courses and which are wales (Yuksel et al. 2012, section 5.1)."""

from stitchmesh.labeling.label import label

__all__ = ["label"]
