# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Labeling of the edges of a mesh as course edges and wale edges (Yuksel et al. 2012, section 5.1)."""

from stitchmesh.labeling.label import label

__all__ = ["label"]
