# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where to put yarns: triangles chosen by place, by stitches, or by the error of triangles alone."""
