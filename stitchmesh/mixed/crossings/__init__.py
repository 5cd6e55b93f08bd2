# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as nodes at their crossings, along which they slide (Cirio et al. 2014 for weaves, 2017 for knits).

A node has one position for both yarns. The crimp of a weave is therefore not an unknown, and the exchange of crimp
between warp and weft (Peirce) does not occur; crimp enters only the normal forces of friction (``normal_forces``).
"""
