# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the region of interest and of what couples yarns and triangles."""
