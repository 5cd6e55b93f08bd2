# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Labeling of the edges of a mesh as course edges and wale edges (Yuksel et al. 2012, section 5.1)."""

from stitchmesh.labeling.faults import LabelingFault
from stitchmesh.labeling.label import label
from stitchmesh.labeling.labeling_file import read_labeling, write_labeling
from stitchmesh.labeling.partial_labeling import PartialLabeling, start_labeling

__all__ = ["LabelingFault", "PartialLabeling", "label", "read_labeling", "start_labeling", "write_labeling"]
