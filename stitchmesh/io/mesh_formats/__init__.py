# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Formats of polygon meshes; each format has a module of its own, except those that meshio reads and writes."""
