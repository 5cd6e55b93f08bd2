# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cloth of triangles with yarns in a region of interest, in one system (Casafranca et al. 2020)."""
