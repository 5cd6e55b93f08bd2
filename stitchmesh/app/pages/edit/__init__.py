# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Edit: stitches, yarns, patterns, cables and the shape of the stitch mesh."""
