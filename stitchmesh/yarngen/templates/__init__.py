# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Templates of stitches: the yarn parts of one stitch on a flat face."""
