# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pipeline from a polygon mesh to files of relaxed yarns."""
