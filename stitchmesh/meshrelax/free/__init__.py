# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation without a surface: the natural shape of a fabric (Yuksel et al. 2012, section 7)."""
