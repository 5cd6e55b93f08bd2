# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The limit surface of a mesh, its borders, and closest points on it."""
