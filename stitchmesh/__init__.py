# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""StitchMesh: from a polygon mesh to knitted, relaxed yarns."""
