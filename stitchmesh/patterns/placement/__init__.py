# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Application of patterns to a stitch mesh: where the tiles lie, and which faces change."""
