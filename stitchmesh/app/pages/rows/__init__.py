# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Rows: rows and stitches of meshes without modelled rows."""
