# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as nodes at their crossings, along which they slide (Cirio et al. 2014 for weaves, 2017 for knits)."""
