# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation without a surface: the natural shape of a piece, a tube or a repeat (Yuksel et al. 2012, section 7)."""
