# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Meshes of faces of any type, as ``.smobj`` files of other programs hold them, and the yarns of their faces.

A face whose type is a stitch has the yarn of the stitch. Any other face keeps its type, and takes its yarn from a face
library or from the labels of its sides.
"""
