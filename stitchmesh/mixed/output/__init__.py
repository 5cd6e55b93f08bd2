# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a run of the mixed system leaves: smooth triangles and yarns for display, maps, frames, files, the report."""
