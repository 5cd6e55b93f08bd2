# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Text formats of stitch meshes: ``.smobj``, and knitout programs for knitting machines."""
