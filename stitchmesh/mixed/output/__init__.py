# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The results of a run of the mixed system: smooth triangles and yarns for display, maps, frames, files, the report."""
